//! Motion blur against closed forms: all rays of a path see the scene at one time, uniform in the shutter interval.

mod common;

use common::moving::*;
use common::*;
use dapple_camera::{Projection, Shutter};
use dapple_geometry::Mesh;
use dapple_geometry::bvh::Kernel;
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::settings::Strategy;
use dapple_integrator::{Backfaces, Effect, MethodKind, Outcome, SampleSets, Settings};
use dapple_lights::Environment;
use dapple_materials::Material;
use dapple_math::motion::{Channel, Interpolation, Node, Track, Trs};
use dapple_scene::{CameraPose, Scene, SceneBuilder, TexturedMaterial};
use dapple_testkit::{quadrature, z_test};
use glam::{DAffine3, DQuat, DVec3, Vec3, Vec4};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A rotation by `total` radians about an axis, with keys at most a quarter turn apart.
fn spin(axis: DVec3, total: f64) -> Vec<Node> {
    let n = (total.abs() / (PI / 2.0)).ceil() as usize;
    let turn = |i: usize| {
        let half = total * i as f64 / n as f64 / 2.0;
        let v = axis * libm::sin(half);
        DQuat::from_xyzw(v.x, v.y, v.z, libm::cos(half))
    };
    vec![Node::Trs(Trs { rotation: over_shutter((0..=n).map(turn).collect()), ..Trs::default() })]
}

fn fixed(t: DVec3) -> Node {
    Node::Fixed(DAffine3::from_translation(t))
}

/// An orthographic camera at `from` along `forward`; a pixel of an image `height` pixels high is one unit.
fn flat_view(from: DVec3, forward: DVec3, up: DVec3, height: f64) -> SceneBuilder {
    let mut builder = SceneBuilder::new("test");
    builder.exposure(AT, SHUTTER);
    let pose = CameraPose::look_at(from, from + forward, up, 1.0);
    let projection = Projection::Orthographic { half_height: (height / 2.0) as f32 };
    builder.camera("camera", CameraPose { projection, ..pose });
    builder
}

fn settings(size: (u32, u32), spp: u32) -> Settings {
    Settings { size, pattern: Pattern::Random, ..Settings::default() }.with_spp(spp)
}

/// The distribution tracer with four time samples at each of the points of a pixel; all are independent, so that its
/// error is no larger than that of as many paths as points.
fn distribution(size: (u32, u32), points: u32) -> Settings {
    let random = |n| SampleSet::new(n, Pattern::Random);
    let plans =
        SampleSets { pixel: random(points), time: random(4), light: random(1), ..SampleSets::default() };
    Settings { plans, ..settings(size, 1) }.with_method(MethodKind::Distribution).with_spp(points)
}

/// G of docs/science.md, "Moving box": the integral to x of the coverage of a box from 0 to w that moves by Δ.
fn streak(x: f64, w: f64, delta: f64) -> f64 {
    let square = |x: f64| x.max(0.0) * x.max(0.0);
    (square(x) - square(x - w) - square(x - delta) + square(x - w - delta)) / (2.0 * delta)
}

/// Asserts that every column of the image has the mean `expected(column)` within 4 standard errors of `spp` samples of
/// an indicator times `scale`.
#[track_caller]
fn assert_columns(what: &str, outcome: &Outcome, scale: f64, expected: impl Fn(f64) -> f64) {
    let mean = outcome.film.mean();
    let n = f64::from(outcome.stats.spp) * mean.height as f64;
    let columns = mean.width;
    for x in 0..columns {
        let sum: f64 = (0..mean.height).map(|y| f64::from(mean.at(x, y).x)).sum();
        let (got, p) = (sum / mean.height as f64 / scale, expected(x as f64));
        let error = 4.0 * (p * (1.0 - p) / n).max(0.0).sqrt() + 1e-5;
        assert!((got - p).abs() <= error, "{what}, column {x}: {got}, exact {p} ± {error}");
    }
}

/// A plate from 0 to w that covers all rows, at height z.
fn plate(w: f64, z: f64) -> Mesh {
    quad(Vec3::new(0.0, -8.0, z as f32), Vec3::X * w as f32, Vec3::Y * 16.0)
}

/// docs/science.md, "Moving box".
#[test]
fn a_translating_plate_is_a_trapezoid() {
    for delta in [1e-3, 0.7, 2.4, 1e3] {
        let w = 1.3;
        let mut builder = flat_view(DVec3::new(4.0, 0.0, 5.0), -DVec3::Z, DVec3::Y, 4.0);
        let light = builder.material(matte(0.0, 1.0));
        builder.moving_mesh("plate", plate(w, 0.0), slide(DVec3::ZERO, DVec3::X * delta), light);
        let scene = builder.build().unwrap();
        assert!(scene.survey.has_motion);
        let columns = |x: f64| streak(x + 1.0, w, delta) - streak(x, w, delta);
        let outcome = run(&scene, &settings((8, 4), 8000));
        assert_columns(&format!("Δ = {delta}"), &outcome, 1.0, columns);
        if delta == 2.4 {
            assert!((columns(1.0) - 0.522_916_7).abs() < 1e-6, "the worked example");
        }
        let summed = run(&scene, &distribution((8, 4), 1000));
        assert_columns(&format!("distribution, Δ = {delta}"), &summed, 1.0, columns);
        // If time is off, the plate is at its position when the shutter opens.
        let mut plans = SampleSets::default();
        *plans.of_mut(Effect::Time) = SampleSet::OFF;
        let still = run(&scene, &Settings { plans, ..settings((8, 4), 8000) });
        assert_columns("at the opening", &still, 1.0, |x| (w - x).clamp(0.0, 1.0));
    }
}

/// docs/science.md, "Moving box", in the limit of large motion: half of the time an object is in front of a camera in
/// the middle of its path.
#[test]
fn a_plate_that_crosses_ten_million_pixels() {
    let (w, delta) = (5e6, 1e7);
    let mut builder = flat_view(DVec3::new(6e6, 0.0, 5.0), -DVec3::Z, DVec3::Y, 4.0);
    let light = builder.material(matte(0.0, 1.0));
    builder.moving_mesh("plate", plate(w, 0.0), slide(DVec3::ZERO, DVec3::X * delta), light);
    let outcome = run(&builder.build().unwrap(), &settings((8, 4), 4000));
    assert_columns("Δ = 1e7", &outcome, 1.0, |_| w / delta);
}

/// docs/science.md, "Turning wedge".
#[test]
fn a_wedge_that_turns_by_any_angle() {
    let (beta, r) = (PI / 3.0, 3.0f32);
    let corner = |a: f64| Vec3::new(libm::cos(a) as f32, libm::sin(a) as f32, 0.0) * r;
    let wedge = Mesh {
        positions: vec![Vec3::ZERO, corner(0.0), corner(beta)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    for degrees in [90.0, 180.0, 270.0, 360.0, 1080.0, 1e5] {
        let total = f64::to_radians(degrees);
        for phi in [0.3, 2.0, 4.5] {
            let eye = DVec3::new(libm::cos(phi), libm::sin(phi), 5.0);
            let mut builder = flat_view(eye, -DVec3::Z, DVec3::Y, 1e-4);
            let light = builder.material(matte(0.0, 1.0));
            builder.moving_mesh("wedge", wedge.clone(), spin(DVec3::Z, total), light);
            // |{τ ∈ [0, Θ]: (φ − τ) mod 2π ∈ [0, β]}| / Θ, turn by turn.
            let turns = (total / TAU).ceil() as i32 + 1;
            let covered = (-1..=turns).map(|k| {
                let (from, to) = (phi - beta + TAU * f64::from(k), phi + TAU * f64::from(k));
                (to.min(total) - from.max(0.0)).max(0.0)
            });
            let exact = covered.sum::<f64>() / total;
            let outcome = run(&builder.build().unwrap(), &settings((4, 4), 2500));
            assert_columns(&format!("{degrees}° at {phi}"), &outcome, 1.0, |_| exact);
        }
    }
}

/// A triangulated sphere whose vertex colours encode their positions.
fn painted_ball() -> Mesh {
    let (rings, sides) = (12u32, 24u32);
    let mut mesh = Mesh::default();
    for i in 0..=rings {
        for j in 0..sides {
            let (theta, phi) = (PI * f64::from(i) / f64::from(rings), TAU * f64::from(j) / f64::from(sides));
            let p = DVec3::new(
                libm::sin(theta) * libm::cos(phi),
                libm::sin(theta) * libm::sin(phi),
                libm::cos(theta),
            );
            mesh.positions.push(p.as_vec3());
            let paint = if p.x > 0.2 { 0.9 } else { 0.1 };
            mesh.colors.push(Vec4::new(paint, paint, paint, 1.0));
        }
    }
    for i in 0..rings {
        for j in 0..sides {
            let (a, b) = (i * sides + j, i * sides + (j + 1) % sides);
            mesh.triangles.extend([[a, a + sides, b + sides], [a, b + sides, b]]);
        }
    }
    mesh
}

/// Largest |z| between a square image and itself rotated by a quarter turn.
fn asymmetry(outcome: &Outcome) -> f64 {
    let (mean, variance) = (outcome.film.mean(), outcome.film.variance());
    let n = mean.width;
    let mut largest = 0.0f64;
    for (x, y) in (0..n * n).map(|i| (i % n, i / n)) {
        let (u, v) = (n - 1 - y, x);
        let difference = f64::from(mean.at(x, y).x - mean.at(u, v).x);
        let error = f64::from(variance.at(x, y).x + variance.at(u, v).x).sqrt();
        largest = largest.max(difference.abs() / (error + 1e-4));
    }
    largest
}

#[test]
fn three_turns_make_a_painted_ball_round() {
    let scene = |turns: f64| {
        let mut builder = flat_view(DVec3::new(0.0, 0.0, 5.0), -DVec3::Z, DVec3::Y, 2.2);
        let paint = builder.material(matte(1.0, 0.0));
        builder.environment(Environment::constant(Vec3::ONE));
        builder.moving_mesh("ball", painted_ball(), spin(DVec3::Z, TAU * turns), paint);
        builder.build().unwrap()
    };
    let settings = Settings { max_bounces: 1, ..settings((20, 20), 1000) };
    // 400 pixels: by Šidák |z| < 4.8 with probability 1 − 6e-4.
    let round = asymmetry(&run(&scene(3.0), &settings));
    assert!(round < 4.8, "{round}");
    assert!(asymmetry(&run(&scene(0.3), &settings)) > 10.0, "a partial turn must be visible");
}

/// A plate high above a floor under light from straight above: the floor is seen from the side, below the plate.
#[test]
fn the_shadow_of_a_moving_plate_is_the_same_trapezoid() {
    let (w, delta) = (1.7, 3.1);
    let mut builder = flat_view(DVec3::new(4.0, 10.0, 10.0), DVec3::new(0.0, -1.0, -1.0), DVec3::Y, 4.0);
    let white = builder.material(matte(0.6, 0.0));
    let floor = quad(Vec3::new(-20.0, 0.0, 20.0), Vec3::X * 40.0, Vec3::Z * -40.0);
    builder.mesh("floor", floor, DAffine3::IDENTITY, white);
    let black = builder.material(matte(0.0, 0.0));
    let blocker = quad(Vec3::new(0.0, 50.0, 8.0), Vec3::X * w as f32, Vec3::Z * -16.0);
    builder.moving_mesh("plate", blocker, slide(DVec3::ZERO, DVec3::X * delta), black);
    builder.distant_light(DVec3::Y, Vec3::splat(2.0));
    let scene = builder.build().unwrap();
    let lit = 2.0 * 0.6 / PI;
    for settings in [settings((8, 4), 8000), distribution((8, 4), 2000)] {
        let shown = run(&scene, &settings);
        let what = format!("shadow, {:?}", settings.kind());
        assert_columns(&what, &shown, lit, |x| 1.0 - (streak(x + 1.0, w, delta) - streak(x, w, delta)));
    }
}

#[test]
fn the_mirror_image_of_a_moving_plate_is_the_same_trapezoid() {
    let (w, delta, kr) = (1.7, 3.1, 0.8);
    let mut builder = flat_view(DVec3::new(4.0, 0.0, 5.0), -DVec3::Z, DVec3::Y, 4.0);
    let mirror = Material { base_color: Vec3::ONE, metallic: 1.0, roughness: 0.0, ..Material::default() };
    let mirror = TexturedMaterial {
        base: Material { base_color: Vec3::splat(kr as f32), ..mirror },
        ..Default::default()
    };
    let mirror = builder.material(mirror);
    builder.mesh(
        "mirror",
        quad(Vec3::new(-20.0, -20.0, 0.0), Vec3::X * 40.0, Vec3::Y * 40.0),
        DAffine3::IDENTITY,
        mirror,
    );
    // Behind the camera, facing the mirror.
    let light = builder.material(TexturedMaterial { double_sided: true, ..matte(0.0, 1.0) });
    builder.moving_mesh("plate", plate(w, 9.0), slide(DVec3::ZERO, DVec3::X * delta), light);
    let scene = builder.build().unwrap();
    for settings in [settings((8, 4), 8000), distribution((8, 4), 2000)] {
        let shown = run(&scene, &settings);
        let what = format!("mirror, {:?}", settings.kind());
        assert_columns(&what, &shown, kr, |x| streak(x + 1.0, w, delta) - streak(x, w, delta));
    }
}

/// A small floor under a light, seen as a single point; see [`irradiance_meter`].
fn meter() -> SceneBuilder {
    let mut builder = irradiance_meter();
    builder.exposure(AT, SHUTTER);
    builder
}

#[test]
fn irradiance_under_lights_that_move() {
    let settings = |side, spp| Settings { size: (side, side), ..Settings::default() }.with_spp(spp);
    // ∫ I h/(x² + h²)^{3/2} dx / 2a from −a to a = I/(h·√(a² + h²)).
    let (a, h) = (1.5, 0.8);
    let mut builder = meter();
    builder.point_light(DVec3::ZERO, Vec3::splat(3.0), f64::INFINITY);
    builder.moving_light(slide(DVec3::new(-a, h, 0.0), DVec3::new(a, h, 0.0)));
    let exact = 3.0 / (h * f64::hypot(a, h)) / PI;
    assert_close("point light", &run(&builder.build().unwrap(), &settings(16, 64)), exact);
    // From the zenith to an angle Θ: ∫ cosθ dθ/Θ.
    let theta = 1.2;
    let mut builder = meter();
    builder.distant_light(DVec3::Y, Vec3::splat(2.0));
    builder.moving_light(spin(DVec3::Z, theta));
    let exact = 2.0 * libm::sin(theta) / theta / PI;
    assert_close("distant light", &run(&builder.build().unwrap(), &settings(16, 64)), exact);
    // The cone of a spot light turns away over the point below it: the point is lit while its angle is within the cone.
    let mut builder = meter();
    let axis = DVec3::NEG_Y;
    builder.spot_light(DVec3::ZERO, axis, Vec3::splat(2.0), f64::INFINITY, 0.5, 0.5);
    let mut chain = vec![fixed(DVec3::Y * 2.0)];
    chain.extend(spin(DVec3::Z, theta));
    builder.moving_light(chain);
    let outcome = run(&builder.build().unwrap(), &settings(16, 256));
    // Half of glTF's narrowest edge, 0.001 in the cosine, is uncertain.
    let (mean, _) = mean_and_error(&outcome);
    assert!((mean * PI / 0.5 - 0.5 / theta).abs() < 0.01, "spot light: {mean}");
}

/// Corner form of a rectangle parallel to the receiver [Howell 2010]: E = πL·C.
fn corner(x: f64, y: f64) -> f64 {
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / p * (y / p).atan() + y / q * (x / q).atan()) / (2.0 * PI)
}

#[test]
fn irradiance_under_a_quad_that_moves() {
    let (half, h, a) = (0.4, 1.0, 2.0);
    let mut builder = meter();
    let lamp = builder.material(matte(0.0, 5.0));
    let (s, side) = (half as f32, 2.0 * half as f32);
    let down = quad(Vec3::new(-s, 0.0, -s), Vec3::X * side, Vec3::Z * side);
    builder.moving_mesh("lamp", down, slide(DVec3::new(-a, h, 0.0), DVec3::new(a, h, 0.0)), lamp);
    let scene = builder.build().unwrap();
    assert_eq!(scene.lights.len(), 1, "two triangles that move are one quad");
    let at = |x: f64| 2.0 * (corner((x + half) / h, half / h) - corner((x - half) / h, half / h));
    let exact = 5.0 * quadrature::line(at, -a, a, 1e-8) / (2.0 * a);
    for strategy in [Strategy::Both, Strategy::LightOnly] {
        let settings =
            Settings { size: (24, 24), strategy, max_bounces: 1, ..Settings::default() }.with_spp(256);
        assert_close("moving quad", &run(&scene, &settings), exact);
    }
    let settings = Settings { max_bounces: 1, ..distribution((24, 24), 96) };
    assert_close("moving quad, summed", &run(&scene, &settings), exact);
}

/// Lamps of all shapes that translate, rotate, scale and mirror themselves, over a floor.
fn restless_lamps() -> Scene {
    let mut builder = seen(DVec3::new(0.0, 3.0, 7.0), DVec3::new(0.0, 0.5, 0.0), 0.8);
    builder.exposure(AT, SHUTTER);
    let white = builder.material(matte(0.7, 0.0));
    let floor = quad(Vec3::new(-6.0, 0.0, 6.0), Vec3::X * 12.0, Vec3::Z * -12.0);
    builder.mesh("floor", floor, DAffine3::IDENTITY, white);
    let lamp = builder.material(matte(0.0, 6.0));
    let sheet = builder.material(TexturedMaterial { double_sided: true, ..matte(0.0, 4.0) });
    let mut chain = vec![fixed(DVec3::new(-2.0, 1.2, 0.0))];
    chain.extend(spin(DVec3::new(0.6, 0.8, 0.0), 7.0));
    builder.moving_mesh("sheet", quad(Vec3::new(-0.5, -0.3, 0.0), Vec3::X, Vec3::Y * 0.6), chain, sheet);
    // Through its own mirror image: the scale of x goes from 1 to −1.
    let scale = over_shutter(vec![DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0)]);
    let flip = vec![fixed(DVec3::new(0.0, 1.5, 0.0)), Node::Trs(Trs { scale, ..Trs::default() })];
    let tent = Mesh {
        positions: vec![Vec3::new(0.2, 0.0, -0.5), Vec3::new(0.9, 0.3, 0.0), Vec3::new(0.2, 0.0, 0.6)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    builder.moving_mesh("triangle", tent, flip, lamp);
    let swell = over_shutter(vec![DVec3::splat(0.2), DVec3::splat(1.5)]);
    let slide = over_shutter(vec![DVec3::new(1.0, 0.7, 1.0), DVec3::new(3.0, 1.5, -1.0)]);
    let swell = vec![Node::Trs(Trs { scale: swell, translation: slide, ..Trs::default() })];
    builder.moving_sphere("ball", 0.25, swell, lamp);
    let mut wobble = vec![fixed(DVec3::new(0.0, 2.0, -2.0))];
    wobble.extend(spin(DVec3::X, 4.0));
    builder.moving_disk("disk", 0.6, wobble, lamp);
    builder.build().unwrap()
}

#[test]
fn light_and_bsdf_sampling_agree_on_lights_that_move() {
    let scene = restless_lamps();
    assert_eq!(scene.lights.len(), 4);
    let by = |strategy, seed| {
        run(&scene, &Settings { seed, strategy, max_bounces: 2, ..settings((24, 16), 1024) })
    };
    let both = by(Strategy::Both, 1);
    for (other, seed) in [(Strategy::LightOnly, 2), (Strategy::BsdfOnly, 3)] {
        assert_agree("strategies", &both, &by(other, seed));
    }
    let still = {
        let mut plans = SampleSets::default();
        *plans.of_mut(Effect::Time) = SampleSet::OFF;
        run(&scene, &Settings { plans, max_bounces: 2, ..settings((24, 16), 1024) })
    };
    assert!(largest_z(&both, &still) > 20.0, "the motion must be visible");
}

/// Largest |z| over the pixels' green.
fn largest_z(a: &Outcome, b: &Outcome) -> f64 {
    let (ma, mb, va, vb) = (a.film.mean(), b.film.mean(), a.film.variance(), b.film.variance());
    let z = |i: usize| {
        let error = f64::from(va.pixels[i].y + vb.pixels[i].y).sqrt();
        f64::from(ma.pixels[i].y - mb.pixels[i].y).abs() / (error + 1e-9)
    };
    (0..ma.pixels.len()).map(z).fold(0.0, f64::max)
}

/// Compares tiles that are wide enough for every lamp to pass through each.
#[track_caller]
fn assert_agree(what: &str, a: &Outcome, b: &Outcome) {
    assert_eq!(a.stats.bad_sample_count + b.stats.bad_sample_count, 0, "{what}");
    let green = |p: dapple_imaging::Image| p.pixels.iter().map(|v| f64::from(v.y)).collect::<Vec<_>>();
    let [a, b] = [a, b].map(|o| (green(o.film.mean()), green(o.film.variance())));
    let channels = [&a, &b].map(|(mean, variance)| z_test::Channel { mean, variance });
    let tiles = z_test::tiles(channels[0], channels[1], 24, 8, 1e-4);
    assert!(tiles.passed(), "{what}: {:?}", tiles.whole);
}

/// Both tracers on moving lights and geometry.
#[test]
fn both_tracers_see_the_same_motion() {
    let scene = restless_lamps();
    let path = run(&scene, &Settings { seed: 4, max_bounces: 2, ..settings((24, 16), 1024) });
    let random = |n| SampleSet::new(n, Pattern::Random);
    let plans = SampleSets {
        pixel: random(64),
        time: random(8),
        light: random(1),
        diffuse: random(1),
        glossy: random(1),
        ..SampleSets::default()
    };
    let method = MethodKind::Distribution;
    let distribution =
        Settings { plans, max_bounces: 2, ..settings((24, 16), 1) }.with_method(method).with_spp(64);
    assert_agree("tracers", &path, &run(&scene, &distribution));
}

/// A camera that moves past objects at rest, and objects that move past a camera at rest.
#[test]
fn a_moving_camera_is_a_moving_world() {
    let go = DVec3::new(1.1, 0.4, -0.9);
    let build = |camera_moves: bool| {
        let mut builder = SceneBuilder::new("test");
        builder.exposure(AT, SHUTTER);
        let pose = CameraPose::look_at(DVec3::new(0.0, 1.5, 6.0), DVec3::ZERO, DVec3::Y, 0.7);
        let still = || vec![fixed(DVec3::ZERO)];
        let (camera, accel) = match camera_moves {
            true => (slide(DVec3::ZERO, go), still()),
            false => (still(), slide(DVec3::ZERO, -go)),
        };
        builder.moving_camera("camera", pose, camera);
        let white = builder.material(matte(0.7, 0.0));
        let shiny = builder.material(metal(Vec3::new(0.9, 0.6, 0.3), 0.2));
        let lamp = builder.material(matte(0.0, 8.0));
        let floor = quad(Vec3::new(-5.0, -1.0, 5.0), Vec3::X * 10.0, Vec3::Z * -10.0);
        builder.moving_mesh("floor", floor, accel.clone(), white);
        builder.moving_mesh("ball", painted_ball(), accel.clone(), shiny);
        builder.moving_mesh("lamp", quad(Vec3::new(-1.0, 3.0, -1.0), Vec3::X, Vec3::Z), accel.clone(), lamp);
        builder.point_light(DVec3::new(2.0, 2.0, 3.0), Vec3::splat(20.0), f64::INFINITY);
        builder.moving_light(accel);
        builder.build().unwrap()
    };
    let (a, b) = (build(true), build(false));
    assert!(a.cameras[0].camera.motion.is_some() && !a.accel.has_motion());
    assert!(b.cameras[0].camera.motion.is_none() && b.accel.has_motion());
    let by = |scene: &Scene, seed| run(scene, &Settings { seed, max_bounces: 3, ..settings((24, 16), 1024) });
    assert_agree("relative motion", &by(&a, 5), &by(&b, 6));
}

fn bits(outcome: &Outcome) -> Vec<[u32; 3]> {
    outcome.film.mean().pixels.iter().map(|p| p.to_array().map(f32::to_bits)).collect()
}

#[test]
fn threads_and_kernels_change_no_bit_of_motion() {
    let mut scene = restless_lamps();
    let settings =
        |threads| Settings { size: (70, 37), ..Settings::default() }.with_threads(threads).with_spp(5);
    let one = bits(&run(&scene, &settings(1)));
    assert_eq!(one, bits(&run(&scene, &settings(2))));
    for kernel in Kernel::available() {
        scene.accel = scene.accel.with_kernel(kernel);
        assert_eq!(one, bits(&run(&scene, &settings(2))), "{}", kernel.name());
    }
}

/// Objects that stand still, or move only while the shutter is closed, cost nothing and change no bit.
#[test]
fn an_open_shutter_over_things_at_rest_changes_no_bit() {
    let build = |shutter: Option<Shutter>| {
        let mut builder = seen(DVec3::new(0.0, 2.0, 6.0), DVec3::ZERO, 0.7);
        let white = builder.material(matte(0.7, 0.0));
        let lamp = builder.material(matte(0.0, 8.0));
        let ball = DVec3::new(0.3, 0.2, 0.1);
        match shutter {
            None => builder.mesh("ball", painted_ball(), DAffine3::from_translation(ball), white),
            Some(shutter) => {
                builder.exposure(AT, shutter);
                // It arrives before the shutter opens.
                let track = Track::new(vec![0.0, 1.0], vec![DVec3::ZERO, ball], Interpolation::Linear);
                let translation = Channel::Track(Arc::new(track.unwrap()));
                let chain = vec![Node::Trs(Trs { translation, ..Trs::default() })];
                builder.moving_mesh("ball", painted_ball(), chain, white)
            }
        };
        builder.mesh("lamp", quad(Vec3::new(-1.0, 3.0, -1.0), Vec3::X, Vec3::Z), DAffine3::IDENTITY, lamp);
        builder.build().unwrap()
    };
    let settings = Settings { size: (40, 30), ..Settings::default() }.with_spp(4);
    let closed = run(&build(None), &settings);
    for shutter in [SHUTTER, Shutter { open: 1.0, close: 1.0 }, Shutter { open: -3.0, close: 1e4 }] {
        let scene = build(Some(shutter));
        assert!(!scene.survey.has_motion);
        let open = run(&scene, &settings);
        assert_eq!(bits(&closed), bits(&open));
        assert_eq!(closed.stats.rays, open.stats.rays);
    }
}

/// Every wall emits 1 and reflects half, at any position: the radiance is 2, whatever the size and the position of the
/// scene (docs/science.md, "Closed room").
#[test]
fn a_moving_furnace_at_every_scale() {
    for (scale, offset) in [(1e-6, 0.0), (1.0, 0.0), (1e6, 0.0), (1.0, 1e5), (1.0, 1e7)] {
        let centre = DVec3::splat(offset);
        let eye = centre + DVec3::new(0.31, -0.22, 0.4) * scale;
        let mut builder = seen(eye, eye + DVec3::new(-0.6, 0.3, -0.7) * scale, 1.6);
        builder.exposure(AT, SHUTTER);
        let wall = builder.material(matte(0.5, 1.0));
        let place = DAffine3::from_translation(centre) * DAffine3::from_scale(DVec3::splat(scale));
        let mut chain = vec![Node::Fixed(place)];
        chain.extend(slide(DVec3::ZERO, DVec3::new(0.2, 0.1, 0.3)));
        chain.extend(spin(DVec3::new(0.0, 0.6, 0.8), 1.0));
        builder.moving_mesh("cube", inward_cube(), chain, wall);
        let scene = builder.build().unwrap();
        let settings = Settings { size: (16, 16), max_bounces: 40, ..Settings::default() }
            .with_spp(64)
            .with_path(|p| p.roulette = false);
        assert_close(&format!("moving furnace of size {scale} at {offset}"), &run(&scene, &settings), 2.0);
    }
}

/// Normals and hidden back faces move with the object.
#[test]
fn the_hidden_side_turns_with_its_object() {
    let half_turn = |backfaces| {
        let mut builder = flat_view(DVec3::new(0.0, 0.0, 5.0), -DVec3::Z, DVec3::Y, 1e-6);
        let unlit = TexturedMaterial { unlit: true, ..matte(1.0, 1.0) };
        let light = builder.material(unlit);
        let card = quad(Vec3::new(-1.0, -1.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0);
        builder.moving_mesh("card", card, spin(DVec3::Y, TAU), light);
        let scene = builder.build().unwrap();
        run(&scene, &Settings { backfaces, ..settings((4, 4), 2500) })
    };
    assert_columns("from both sides", &half_turn(Backfaces::Shown), 1.0, |_| 1.0);
    assert_columns("from the front only", &half_turn(Backfaces::Culled), 1.0, |_| 0.5);
}
