//! Convergence rates and error estimates of renders whose pixels are known in closed form.
//!
//! The scene is a floor seen from above and lit by an area light outside the image (irradiance of a rectangle), either
//! alone or behind a screen whose slanted edge cuts the light as seen from every pixel (irradiance of a polygon). Only
//! the light's integral is enabled. The expected slopes are those of docs/science.md, "Convergence rates" in two
//! dimensions.

use dapple_analysis::converge::{Allowance, Reference, Run, measure};
use dapple_analysis::curve::{Curve, Error, Over, slope};
use dapple_analysis::estimate::{Estimate, Way, replicate, within};
use dapple_analysis::metrics::{Scale, compare};
use dapple_integrator::camera::Projection;
use dapple_integrator::geometry::Mesh;
use dapple_integrator::imaging::Image;
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::scene::{CameraPose, Scene, SceneBuilder, TexturedMaterial};
use dapple_integrator::{Effect, MethodKind, SampleSets, Settings, render};
use dapple_verify::closed_form::{parallel_rectangle, polygon};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use std::ops::ControlFlow;

const SIDE: u32 = 12;
/// Half side of the visible square, and its centre.
const HALF: f64 = 0.15;
const MIDDLE: f64 = 0.85;
/// Corners of the light, and its height.
const LOW: [f64; 2] = [1.2, -0.6];
const HIGH: [f64; 2] = [2.2, 0.5];
const HEIGHT: f64 = 0.8;
/// The screen, at half the height of the light, begins at x = EDGE + SLANT·y.
const EDGE: f64 = 1.3;
const SLANT: f64 = 0.35;

fn matte(albedo: f32, emission: f32) -> TexturedMaterial {
    TexturedMaterial {
        emission: Vec3::splat(emission),
        double_sided: true,
        ..TexturedMaterial::lambert("matte", Vec3::splat(albedo))
    }
}

fn quad(a: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Mesh {
    let [a, u, v] = [a, u, v].map(|p| DVec3::from(p).as_vec3());
    Mesh {
        positions: vec![a, a + u, a + u + v, a + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn scene(screen: bool) -> Scene {
    let mut builder = SceneBuilder::new("lamp");
    let transform = DAffine3 { matrix3: DMat3::IDENTITY, translation: DVec3::new(MIDDLE, 0.0, 5.0) };
    let projection = Projection::Orthographic { half_height: HALF as f32 };
    builder.camera("camera", CameraPose { transform, projection, aspect: None, clip: None });
    let [white, black, bright] =
        [(1.0, 0.0), (0.0, 0.0), (0.0, 1.0)].map(|(a, e)| builder.material(matte(a, e)));
    let mut add = |name: &str, mesh, material| builder.mesh(name, mesh, DAffine3::IDENTITY, material);
    add("floor", quad([0.0, -1.0, 0.0], [1.1, 0.0, 0.0], [0.0, 2.0, 0.0]), white);
    let (width, depth) = (HIGH[0] - LOW[0], HIGH[1] - LOW[1]);
    add("lamp", quad([LOW[0], LOW[1], HEIGHT], [0.0, depth, 0.0], [width, 0.0, 0.0]), bright);
    if screen {
        let start = [EDGE - 3.0 * SLANT, -3.0, 0.5 * HEIGHT];
        add("screen", quad(start, [6.0 * SLANT, 6.0, 0.0], [4.0, 0.0, 0.0]), black);
    }
    builder.build().unwrap()
}

/// The exact image.
fn exact(screen: bool) -> Image {
    let at = |i: u32| (2.0 * (f64::from(i) + 0.5) / f64::from(SIDE) - 1.0) * HALF;
    let one = |i: u32| {
        let p = [MIDDLE + at(i % SIDE), -at(i / SIDE)];
        let shifted = |q: [f64; 2]| [q[0] - p[0], q[1] - p[1]];
        let radiance = match screen {
            false => parallel_rectangle(shifted(LOW), shifted(HIGH), HEIGHT),
            true => {
                let seen: Vec<[f64; 3]> =
                    seen(p).into_iter().map(shifted).map(|q| [q[0], q[1], HEIGHT]).collect();
                polygon(&seen)
            }
        };
        Vec3::splat(radiance as f32)
    };
    Image { width: SIDE as usize, height: SIDE as usize, pixels: (0..SIDE * SIDE).map(one).collect() }
}

/// The part of the light that is visible from p past the screen: the midpoint between both lies before the edge.
fn seen(p: [f64; 2]) -> Vec<[f64; 2]> {
    let corners = [LOW, [HIGH[0], LOW[1]], HIGH, [LOW[0], HIGH[1]]];
    let beyond = |q: [f64; 2]| 0.5 * (p[0] + q[0]) - EDGE - SLANT * 0.5 * (p[1] + q[1]);
    let mut kept = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % 4];
        let (da, db) = (beyond(a), beyond(b));
        if da <= 0.0 {
            kept.push(a);
        }
        if (da <= 0.0) != (db <= 0.0) {
            let t = da / (da - db);
            kept.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
        }
    }
    assert!(kept.len() > 2, "the edge must cut the light");
    kept
}

fn settings(method: MethodKind, pattern: Pattern, count: u32) -> Settings {
    let light = SampleSet::new(count, pattern);
    let plans = SampleSets { pixel: SampleSet::OFF, light, diffuse: SampleSet::OFF, ..SampleSets::default() };
    let spp = Some(count);
    Settings { pattern, plans, max_bounces: 1, size: (SIDE, SIDE), ..Settings::default() }
        .with_method(method)
        .with_threads(2)
        .with_spp(spp)
}

/// The slope from 16 to 1024 points, with its interval over seeds.
fn fitted(
    scene: &Scene,
    reference: &Reference,
    method: MethodKind,
    pattern: Pattern,
) -> dapple_analysis::statistics::Interval {
    let run = Run {
        name: "run".into(),
        camera: scene.cameras[0].camera.clone(),
        settings: settings(method, pattern, 1),
        vary: Effect::Light,
    };
    let allowance = Allowance { seconds: 0.0, most: Some(1024), stop: &|_| false, cpu_seconds: &|| 0.0 };
    let curve = |seed: u64| -> Curve {
        let found = measure(scene, &run, seed, reference, &allowance).unwrap().curve;
        found.into_iter().filter(|p| p.samples >= 16.0).collect()
    };
    let curves: Vec<Curve> = (1..=8).map(curve).collect();
    slope(&curves, Over::Samples, Error::Mse).unwrap()
}

#[test]
fn slopes_are_those_of_theory() {
    for (screen, random, stratified, sobol) in [(false, -1.0, -2.0, -2.88), (true, -1.0, -1.5, -1.5)] {
        let (scene, reference) = (scene(screen), Reference::Exact(exact(screen)));
        for (pattern, expected) in
            [(Pattern::Random, random), (Pattern::Stratified, stratified), (Pattern::Sobol, sobol)]
        {
            for method in [MethodKind::Path, MethodKind::Distribution] {
                let found = fitted(&scene, &reference, method, pattern);
                println!("screen {screen}, {method:?}, {pattern}: {found:?}, expected {expected}");
                // The tolerance is that of the table; the interval must be narrow enough to distinguish the rates.
                assert!(found.high - found.low < 0.2, "{found:?}");
                assert!(
                    (found.value - expected).abs() <= 0.1,
                    "screen {screen}, {method:?}, {pattern}: {found:?}, not {expected}"
                );
            }
        }
    }
}

/// Over 40 seeds the stated error equals the true error on average, and the bound holds as often as its confidence
/// states.
#[test]
fn stated_errors_are_the_true_ones() {
    for screen in [false, true] {
        let (scene, exact) = (scene(screen), exact(screen));
        for (method, pattern) in [
            (MethodKind::Path, Pattern::Random),
            (MethodKind::Path, Pattern::Stratified),
            (MethodKind::Path, Pattern::Sobol),
            (MethodKind::Distribution, Pattern::Stratified),
        ] {
            let (mut stated, mut truth, mut held) = (0.0, 0.0, 0);
            for seed in 0..40 {
                let settings = Settings { seed, ..settings(method, pattern, 64) };
                let (found, true_error) = stated_and_true(&scene, &settings, &exact);
                stated += found.error * found.error;
                truth += true_error * true_error;
                held += u32::from(true_error <= found.bound);
            }
            let ratio = f64::sqrt(stated / truth);
            println!("screen {screen}, {method:?}, {pattern}: stated / true {ratio:.3}, held {held} of 40");
            // For 144 pixels times 40 seeds, two standard errors are 3 %, more if few pixels dominate the error.
            assert!((0.9..1.1).contains(&ratio), "screen {screen}, {method:?}, {pattern}: {ratio}");
            // The probability that Binomial (40, 0.95) is below 33 is 1e-4.
            assert!(held >= 33, "screen {screen}, {method:?}, {pattern}: {held}");
        }
    }
}

fn stated_and_true(scene: &Scene, settings: &Settings, exact: &Image) -> (Estimate, f64) {
    let camera = &scene.cameras[0].camera;
    let outcome = render(scene, camera, settings, &|_| ControlFlow::Continue(()));
    let (film, spp) = (outcome.film, outcome.stats.spp);
    let found = match Way::of(settings) {
        Way::Within => within(&film, 0.95),
        _ => replicate(scene, camera, settings, (&film, spp), 0.95),
    };
    let truth = compare(&film.mean(), exact, &Scale::default()).unwrap().overall.relative_rmse;
    (found.unwrap(), truth)
}
