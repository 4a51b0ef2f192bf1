//! The sky on diffuse lobes that are not sampled is an integral with the light's sample set: a ball above a floor
//! blocks half of the irradiance, so that every direction is a Bernoulli trial of known probability, and the errors
//! follow.

mod common;

use common::*;
use dapple_imaging::Image;
use dapple_integrator::{Combine, MethodKind, SampleSets, Settings, forecast};
use dapple_lights::Environment;
use dapple_materials::{Material, Mirror};
use dapple_sampling::{Moments, Pattern, SampleSet};
use dapple_scene::{Scene, TexturedMaterial};
use glam::{DAffine3, DVec3, Vec3};

/// Unoccluded share of the sky's irradiance, of which the ball blocks (r/h)².
const OPEN: f64 = 0.5;

/// A white floor under a black ball in a constant sky of radiance 1; with `mirrored`, seen in a mirror.
fn shaded(mirrored: bool, sky: Environment) -> Scene {
    let from = DVec3::new(0.9, 0.4, 0.2);
    // The mirror stands at x = 2 and reflects on both sides.
    let at = if mirrored { DVec3::new(4.0, 0.0, 0.0) } else { DVec3::ZERO };
    let mut builder = seen(from, at, 1e-4);
    let white = builder.material(matte(1.0, 0.0));
    let floor = quad(Vec3::new(-0.05, 0.0, 0.05), Vec3::X * 0.1, Vec3::Z * -0.1);
    builder.mesh("floor", floor, DAffine3::IDENTITY, white);
    let black = builder.material(matte(0.0, 0.0));
    builder.sphere("ball", DVec3::Y * 2.0, (4.0 * (1.0 - OPEN)).sqrt(), black);
    if mirrored {
        let base = Material { mirror: Some(Mirror { kr: Vec3::ONE, blur: 0.0 }), ..Material::default() };
        let mirror =
            builder.material(TexturedMaterial { base, double_sided: true, ..TexturedMaterial::default() });
        // Small enough to block a negligible part of the floor's hemisphere.
        let upright = quad(Vec3::new(2.0, 0.20, 0.12), Vec3::Z * -0.01 + Vec3::Y * 0.0, Vec3::Y * 0.01);
        let centred = DAffine3::from_translation(DVec3::new(0.0, 0.053, 0.017));
        builder.mesh("mirror", upright, centred, mirror);
    }
    builder.environment(sky);
    builder.build().unwrap()
}

fn even() -> Environment {
    Environment::constant(Vec3::ONE)
}

fn settings(plans: SampleSets, sky: SampleSet) -> Settings {
    Settings {
        size: (1, 1),
        max_bounces: 3,
        plans: SampleSets { pixel: SampleSet::OFF, diffuse: SampleSet::OFF, ..plans },
        ..Settings::default()
    }
    .with_method(MethodKind::Distribution)
    .with_threads(1)
    .with_distribution(|d| d.sky = sky)
}

fn lit(light: SampleSet) -> Settings {
    settings(SampleSets { light, ..SampleSets::default() }, SampleSets::default().light)
}

fn unlit(sky: SampleSet) -> Settings {
    settings(SampleSets { light: SampleSet::OFF, ..SampleSets::default() }, sky)
}

/// The values of `n` seeds.
fn values(scene: &Scene, settings: &Settings, n: u64) -> Vec<f64> {
    let one = |seed| f64::from(run(scene, &Settings { seed, ..settings.clone() }).film.mean().pixels[0].x);
    (0..n).map(one).collect()
}

fn rmse(values: &[f64], exact: f64) -> f64 {
    (values.iter().map(|v| (v - exact).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Random points have the error √(p(1 − p)/n). For uniformly spread points only the boundary causes errors, n^−¾ on
/// average. This also holds in mirrors, and with lights off for the sky's own sample set. 400 seeds determine a
/// standard deviation to 3.5 %.
#[test]
fn errors_fall_as_they_should() {
    for mirrored in [false, true] {
        let scene = shaded(mirrored, even());
        for with_lights in [true, false] {
            let error = |n, pattern| {
                let plan = SampleSet::new(n, pattern);
                let settings = if with_lights { lit(plan) } else { unlit(plan) };
                rmse(&values(&scene, &settings, if pattern == Pattern::Grid { 1 } else { 400 }), OPEN)
            };
            for n in [16, 64] {
                let found = error(n, Pattern::Random) * f64::from(n).sqrt() / (OPEN * (1.0 - OPEN)).sqrt();
                assert!(
                    (found - 1.0).abs() < 0.14,
                    "mirrored {mirrored}, lights {with_lights}, {n}: {found}"
                );
            }
            for pattern in [Pattern::Stratified, Pattern::Sobol] {
                let slope = (error(16, pattern) / error(256, pattern)).ln() / 16f64.ln();
                assert!((0.62..1.1).contains(&slope), "mirrored {mirrored}, {pattern}: n^-{slope}");
            }
            // The ball's outline follows the rings of the grid, and half a ring may be wrong: 2r·½/(√n/2).
            let most = |n: u32| 1.42 / f64::from(n).sqrt();
            assert!(
                [256, 1024, 4096].iter().all(|n| error(*n, Pattern::Grid) < most(*n)),
                "mirrored {mirrored}"
            );
        }
    }
}

/// A constant sky is not light-sampled, and both ways to specify the sample set are equivalent.
#[test]
fn the_plan_of_the_lights_and_the_skys_own_are_the_same_points() {
    for mirrored in [false, true] {
        let scene = shaded(mirrored, even());
        for pattern in [Pattern::Random, Pattern::Sobol, Pattern::Stratified, Pattern::Grid] {
            let plan = SampleSet::new(9, pattern);
            assert_eq!(values(&scene, &lit(plan), 3), values(&scene, &unlit(plan), 3), "{pattern}");
        }
        let default = SampleSets::default().light;
        let off = SampleSets { light: SampleSet::OFF, ..SampleSets::default() };
        let by_default =
            settings(off, SampleSet::OFF).with_distribution(|d| d.sky = SampleSets::default().light);
        assert_eq!(values(&scene, &by_default, 3), values(&scene, &unlit(default), 3));
    }
}

/// A sky with a sun is also light-sampled; the combination is unbiased for any sample counts, nested and paired, and
/// agrees with the path tracer.
#[test]
fn both_ways_to_the_sky_add_up() {
    let sun = |x, y| if (x, y) == (9, 1) { Vec3::splat(60.0) } else { Vec3::new(0.5, 0.6, 0.7) };
    let pixels = (0..16 * 8).map(|i| sun(i % 16, i / 16)).collect();
    let picture = Image { width: 16, height: 8, pixels };
    for mirrored in [false, true] {
        let sky = Environment::picture(picture.clone(), 0.3, 1.0, false).unwrap();
        let scene = shaded(mirrored, sky);
        let path = lit(SampleSet::new(1, Pattern::Random)).with_method(MethodKind::Path).with_spp(256);
        let moments = |s: &Settings, n| values(&scene, s, n).into_iter().collect::<Moments>();
        let truth = moments(&path, 300);
        let paired = |s: Settings| {
            let pixel = SampleSet::new(16, Pattern::Stratified);
            Settings { plans: SampleSets { pixel, ..s.plans }, ..s }
                .with_distribution(|d| d.combine = Combine::Paired)
        };
        let plans = [(1, Pattern::Random), (16, Pattern::Stratified), (7, Pattern::Sobol)];
        let all = plans.map(|(n, pattern)| SampleSet::new(n, pattern));
        let nested = all.map(lit).into_iter().chain(all.map(unlit));
        let again = [lit(all[1]), unlit(all[1])].map(paired);
        for (i, settings) in nested.chain(again).enumerate() {
            let found = moments(&settings, 600);
            let error = found.standard_error().hypot(truth.standard_error());
            assert!(error < 0.05 * truth.mean, "{i}: {error} is too large to be conclusive");
            let off = (found.mean - truth.mean).abs();
            assert!(off <= 4.0 * error, "mirrored {mirrored}, {i}: {} against {}", found.mean, truth.mean);
        }
    }
}

#[test]
fn its_rays_are_forecast() {
    for mirrored in [false, true] {
        let scene = shaded(mirrored, even());
        for settings in [lit(SampleSet::new(25, Pattern::Sobol)), unlit(SampleSet::new(36, Pattern::Random))]
        {
            let most = forecast(&scene, &scene.cameras[0].camera, &settings).total();
            let took = run(&scene, &settings).stats.rays as f64;
            assert!(took > 25.0 && took <= most, "{took} of at most {most}");
        }
    }
}
