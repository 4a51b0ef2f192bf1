//! The distribution tracer against the path tracer, with every effect on and each one off, and against closed forms.

mod common;

use common::*;
use dapple_integrator::camera::{Aperture, Lens};
use dapple_integrator::{Combine, Effect, MethodKind, Outcome, SampleSets, Settings, render};
use dapple_lights::Environment;
use dapple_materials::{Material, Mirror};
use dapple_sampling::{Pattern, SampleSet};
use dapple_scene::{Scene, TexturedMaterial};
use dapple_testkit::z_test;
use glam::{DAffine3, DVec3, Vec3};
use std::ops::ControlFlow;

/// A scene with all features: a glossy floor, a blurred mirror, frosted glass, a rough metal, a quad, a sphere and a
/// point light, and a dim sky.
fn studio() -> Scene {
    let mut builder = seen(DVec3::new(0.0, 1.2, 4.0), DVec3::new(0.0, 0.6, 0.0), 0.7);
    let plastic = builder.material(TexturedMaterial {
        base: Material {
            base_color: Vec3::new(0.6, 0.4, 0.3),
            metallic: 0.0,
            roughness: 0.6,
            ..Material::default()
        },
        ..TexturedMaterial::default()
    });
    let floor = quad(Vec3::new(-3.0, 0.0, 3.0), Vec3::X * 6.0, Vec3::Z * -6.0);
    builder.mesh("floor", floor, DAffine3::IDENTITY, plastic);
    let mirror = builder.material(TexturedMaterial {
        base: Material { mirror: Some(Mirror { kr: Vec3::splat(0.8), blur: 0.4 }), ..Material::default() },
        ..TexturedMaterial::default()
    });
    let upright = quad(Vec3::new(-1.6, 0.0, -1.0), Vec3::new(1.0, 0.0, -0.3), Vec3::Y * 1.5);
    builder.mesh("mirror", upright, DAffine3::IDENTITY, mirror);
    let frosted = builder.material(TexturedMaterial {
        base: Material {
            metallic: 0.0,
            roughness: 0.5,
            transmission: 0.9,
            base_color: Vec3::splat(0.9),
            ..Material::default()
        },
        ..TexturedMaterial::default()
    });
    let pane = quad(Vec3::new(0.3, 0.0, 0.6), Vec3::X * 0.9, Vec3::Y * 1.1);
    builder.mesh("pane", pane, DAffine3::IDENTITY, frosted);
    let gold = builder.material(metal(Vec3::new(0.9, 0.7, 0.3), 0.6));
    builder.sphere("ball", DVec3::new(0.1, 0.5, -0.5), 0.5, gold);
    let bright = builder.material(matte(0.0, 5.0));
    let above = quad(Vec3::new(-0.6, 2.9, -0.6), Vec3::X * 1.2, Vec3::Z * 1.2);
    builder.mesh("light", above, DAffine3::IDENTITY, bright);
    let warm = builder.material(matte(0.3, 3.0));
    builder.sphere("bulb", DVec3::new(1.5, 1.4, -0.8), 0.35, warm);
    builder.point_light(DVec3::new(-1.5, 1.8, 1.0), Vec3::splat(2.0), f64::INFINITY);
    builder.environment(Environment::constant(Vec3::new(0.1, 0.12, 0.15)));
    let mut scene = builder.build().unwrap();
    let length = |l| scene.space.length_to_render(l);
    scene.cameras[0].camera.lens =
        Some(Lens { aperture: Aperture::Disk, radius: length(0.1), focus_distance: length(3.5) });
    scene
}

fn draw(scene: &Scene, settings: &Settings) -> Outcome {
    render(scene, &scene.cameras[0].camera, settings, &|_| ControlFlow::Continue(()))
}

fn off(effects: &[Effect]) -> SampleSets {
    let mut plans = SampleSets::default();
    effects.iter().for_each(|&effect| *plans.of_mut(effect) = SampleSet::OFF);
    plans
}

fn by_path(scene: &Scene, plans: SampleSets) -> Outcome {
    let settings = Settings {
        size: (16, 12),
        pattern: Pattern::Random,
        max_bounces: 3,
        seed: 7,
        plans,
        ambient: Vec3::splat(0.2),
        ..Settings::default()
    }
    .with_spp(3000);
    draw(scene, &settings)
}

/// Independent points over the pixel, so that the film estimates the error of the integrals nested in them.
fn by_distribution(
    scene: &Scene,
    plans: SampleSets,
    combine: Combine,
    points: u32,
    inner: Pattern,
) -> Outcome {
    let mut plans = plans;
    for effect in [Effect::Lens, Effect::Light, Effect::Glossy, Effect::Refract] {
        if !plans.is_off(effect) {
            *plans.of_mut(effect) = SampleSet::new(4, inner);
        }
    }
    plans.pixel = SampleSet::new(points, Pattern::Random);
    let settings = Settings {
        size: (16, 12),
        max_bounces: 3,
        seed: 8,
        plans,
        ambient: Vec3::splat(0.2),
        ..Settings::default()
    }
    .with_method(MethodKind::Distribution)
    .with_distribution(|d| d.combine = combine);
    draw(scene, &settings)
}

#[track_caller]
fn assert_agree(what: &str, a: &Outcome, b: &Outcome) {
    let channel = |o: &Outcome, of: fn(&Vec3) -> f32| -> (Vec<f64>, Vec<f64>) {
        let all = |p: dapple_imaging::Image| p.pixels.iter().map(|v| f64::from(of(v))).collect();
        (all(o.film.mean()), all(o.film.variance()))
    };
    for (name, of) in [("red", (|v| v.x) as fn(&Vec3) -> f32), ("blue", |v| v.z)] {
        let (a, b) = (channel(a, of), channel(b, of));
        let channels = [&a, &b].map(|(mean, variance)| z_test::Channel { mean, variance });
        let tiles = z_test::tiles(channels[0], channels[1], 16, 4, 1e-4);
        let worst = tiles.tiles.iter().min_by(|a, b| a.test.p.total_cmp(&b.test.p));
        assert!(tiles.passed(), "{what}, {name}: {:?}, {worst:?}", tiles.whole);
    }
}

#[test]
fn with_everything_on_both_tracers_agree() {
    let scene = studio();
    let path = by_path(&scene, SampleSets::default());
    for (combine, points) in [(Combine::Nested, 200), (Combine::Paired, 1500)] {
        for inner in [Pattern::Stratified, Pattern::Sobol] {
            let ours = by_distribution(&scene, SampleSets::default(), combine, points, inner);
            assert_agree(&format!("{combine} {inner}"), &ours, &path);
        }
    }
}

#[test]
fn with_an_effect_off_both_tracers_agree() {
    let scene = studio();
    for effects in [
        vec![Effect::Lens],
        vec![Effect::Light],
        vec![Effect::Glossy],
        vec![Effect::Refract],
        vec![Effect::Diffuse],
        vec![Effect::Light, Effect::Glossy, Effect::Diffuse],
    ] {
        let path = by_path(&scene, off(&effects));
        let ours = by_distribution(&scene, off(&effects), Combine::Nested, 600, Pattern::Stratified);
        assert_agree(&format!("without {effects:?}"), &ours, &path);
    }
}

/// Switching an effect off changes the image; otherwise the test above could not fail.
#[test]
fn each_effect_shows() {
    let scene = studio();
    let all = by_path(&scene, SampleSets::default());
    for effect in [Effect::Lens, Effect::Light, Effect::Glossy, Effect::Refract, Effect::Diffuse] {
        let without = by_path(&scene, off(&[effect]));
        let (a, b) = (all.film.mean(), without.film.mean());
        let differs = a.pixels.iter().zip(&b.pixels);
        let most = differs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
        assert!(most > 0.03, "{effect}: {most}");
    }
}

/// With interreflection off, a sky with a sun still illuminates diffuse surfaces in full, with or without MIS
/// compensation.
#[test]
fn without_interreflection_the_sky_still_lights() {
    let picture = sky();
    let mut builder = irradiance_meter();
    builder.environment(Environment::picture(picture.clone(), 0.0, 1.0, false).unwrap());
    let scene = builder.build().unwrap();
    let exact = sky_irradiance(&picture);
    for method in [MethodKind::Path, MethodKind::Distribution] {
        let mut plans = off(&[Effect::Diffuse]);
        plans.pixel = SampleSet::new(4096, Pattern::Random);
        let settings =
            Settings { plans, size: (4, 4), pattern: Pattern::Random, max_bounces: 3, ..Settings::default() }
                .with_method(method)
                .with_spp(20_000);
        let outcome = draw(&scene, &settings);
        let (mean, error) = mean_and_error(&outcome);
        assert!(
            (mean * std::f64::consts::PI - exact).abs() < 4.0 * std::f64::consts::PI * error + 1e-5 * exact
        );
        assert!(error < 0.01 * mean, "{error} {mean}");
    }
}

/// 16×8 texels: dim blue, brighter towards the zenith, one bright texel.
fn sky() -> dapple_imaging::Image {
    let pixels = (0..128).map(|i| {
        let row = i / 16;
        Vec3::splat(0.3 + 0.1 * (8 - row) as f32)
            + if i == 2 * 16 + 5 { Vec3::splat(40.0) } else { Vec3::ZERO }
    });
    dapple_imaging::Image { width: 16, height: 8, pixels: pixels.collect() }
}

/// ∫ L cosθ dω over the upper half, by midpoints.
fn sky_irradiance(picture: &dapple_imaging::Image) -> f64 {
    let n = 2000;
    let mut sum = 0.0;
    for i in 0..n {
        let theta = (f64::from(i) + 0.5) / f64::from(n) * std::f64::consts::FRAC_PI_2;
        let row = (theta / std::f64::consts::PI * 8.0) as usize;
        let mean = (0..16).map(|x| f64::from(picture.at(x, row).x)).sum::<f64>() / 16.0;
        sum += mean * theta.cos() * theta.sin();
    }
    sum * std::f64::consts::TAU * std::f64::consts::FRAC_PI_2 / f64::from(n)
}

/// E = Σ L·A/n²·cosθ·cosθ'/d² over the cell centres of a quad light, to rounding; 0 = one point.
#[test]
fn a_grid_is_a_set_of_point_lights() {
    let mut builder = irradiance_meter();
    let light = builder.material(matte(0.0, 7.0));
    let corner = Vec3::new(-0.4, 0.8, -0.2);
    builder.mesh("light", quad(corner, Vec3::X * 0.6, Vec3::Z * 0.5), DAffine3::IDENTITY, light);
    let scene = builder.build().unwrap();
    for n in [0u32, 1, 2, 5] {
        let cells = n.max(1);
        let mut exact = 0.0;
        for i in 0..cells * cells {
            let at = |k: u32| (f64::from(k) + 0.5) / f64::from(cells);
            let s = corner.as_dvec3() + DVec3::new(0.6 * at(i % cells), 0.0, 0.5 * at(i / cells));
            let d2 = s.length_squared();
            exact += 7.0 * 0.3 / f64::from(cells * cells) * s.y * s.y / (d2 * d2);
        }
        for method in [MethodKind::Distribution, MethodKind::Path] {
            if method == MethodKind::Path && n > 0 {
                continue;
            }
            let mut plans = off(&[Effect::Diffuse, Effect::Pixel]);
            plans.light = SampleSet { nx: n, ny: n, pattern: Pattern::Grid };
            let settings =
                Settings { plans, size: (1, 1), max_bounces: 1, ..Settings::default() }.with_method(method);
            let got = f64::from(draw(&scene, &settings).film.mean().at(0, 0).x) * std::f64::consts::PI;
            assert!((got / exact - 1.0).abs() < 2e-5, "{method:?} {n}: {got} {exact}");
        }
    }
}

/// The forecast is an upper bound of the traced rays, and exact if every ray hits a surface with all lobes.
#[test]
fn rays_are_forecast() {
    let scene = studio();
    let camera = &scene.cameras[0].camera;
    let mut plans = SampleSets { pixel: SampleSet::new(2, Pattern::Random), ..SampleSets::default() };
    plans.lens = SampleSet::new(3, Pattern::Random);
    for combine in [Combine::Nested, Combine::Paired] {
        let settings = Settings { size: (16, 12), max_bounces: 3, plans, ..Settings::default() }
            .with_method(MethodKind::Distribution)
            .with_distribution(|d| d.combine = combine);
        let traced = draw(&scene, &settings).stats.rays as f64 / (16.0 * 12.0);
        let forecast = dapple_integrator::forecast(&scene, camera, &settings).total();
        assert!(traced <= forecast && traced > 0.02 * forecast, "{combine}: {traced} of {forecast}");
    }
    let mut room = seen(DVec3::ZERO, DVec3::Z, 1.0);
    let wall = room.material(matte(0.5, 1.0));
    room.mesh("room", inward_cube(), DAffine3::IDENTITY, wall);
    let room = room.build().unwrap();
    let plans = SampleSets {
        light: SampleSet::new(3, Pattern::Stratified),
        diffuse: SampleSet::new(2, Pattern::Stratified),
        ..plans
    };
    let settings = Settings { size: (4, 4), max_bounces: 2, plans, ..Settings::default() }
        .with_method(MethodKind::Distribution);
    let traced = draw(&room, &settings).stats.rays as f64 / 16.0;
    let forecast = dapple_integrator::forecast(&room, &room.cameras[0].camera, &settings).total();
    // The only difference is the light in whose plane a point lies: one wall of six.
    assert!((5.0 / 6.0..=1.0).contains(&(traced / forecast)), "{traced} of {forecast}");
}

#[test]
fn threads_and_crops_change_no_bit() {
    let scene = studio();
    let bits = |o: &Outcome| -> Vec<[u32; 3]> {
        o.film.mean().pixels.iter().map(|p| p.to_array().map(f32::to_bits)).collect()
    };
    let settings = Settings {
        size: (20, 16),
        plans: SampleSets { pixel: SampleSet::new(2, Pattern::Stratified), ..SampleSets::default() },
        ..Settings::default()
    }
    .with_method(MethodKind::Distribution)
    .with_threads(1);
    let one = draw(&scene, &settings);
    assert_eq!(bits(&one), bits(&draw(&scene, &settings.clone().with_threads(5))));
    let (_, radiance) = dapple_integrator::replay(
        &scene,
        &scene.cameras[0].camera,
        &Settings {
            plans: SampleSets { pixel: SampleSet::new(1, Pattern::Stratified), ..settings.plans },
            ..settings.clone()
        },
        (5, 6),
        0,
    );
    let single = Settings {
        plans: SampleSets { pixel: SampleSet::new(1, Pattern::Stratified), ..settings.plans },
        ..settings
    };
    assert_eq!(radiance, draw(&scene, &single).film.mean().at(5, 6));
}
