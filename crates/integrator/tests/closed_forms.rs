//! Scenes whose radiance is known in closed form, rendered with the complete path tracer.

mod common;

use common::*;
use dapple_integrator::Settings;
use dapple_lights::Environment;
use dapple_sampling::Pattern;
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::PI;

fn settings(side: u32, spp: u32) -> Settings {
    Settings { size: (side, side), ..Settings::default() }.with_spp(spp)
}

/// Every wall emits 1 and reflects half: L = 1/(1 − ½) = 2 for every size and position (docs/science.md, "Closed
/// room").
fn furnace(scale: f64, offset: f64, mesh_offset: f32) {
    let centre = DVec3::splat(offset);
    let eye = centre + (DVec3::new(0.31, -0.22, 0.4) + DVec3::splat(f64::from(mesh_offset))) * scale;
    let mut builder = seen(eye, eye + DVec3::new(-0.6, 0.3, -0.7) * scale, 1.6);
    let wall = builder.material(matte(0.5, 1.0));
    let mut cube = inward_cube();
    cube.positions.iter_mut().for_each(|p| *p += Vec3::splat(mesh_offset));
    let transform = DAffine3::from_translation(centre) * DAffine3::from_scale(DVec3::splat(scale));
    builder.mesh("cube", cube, transform, wall);
    let scene = builder.build().unwrap();
    // 40 bounces omit 2^-41 of the light.
    let settings = Settings { max_bounces: 40, ..settings(24, 64) }.with_path(|p| p.roulette = false);
    assert_close(
        &format!("furnace of size {scale} at {offset} + {mesh_offset}"),
        &run(&scene, &settings),
        2.0,
    );
}

#[test]
fn closed_furnace_at_every_scale() {
    for k in [-12, -9, -6, -3, 0, 3, 6, 9] {
        furnace(10f64.powi(k), 0.0, 0.0);
    }
}

#[test]
fn closed_furnace_far_from_the_origin() {
    for offset in [1e3, 1e4, 1e5, 1e7] {
        furnace(1.0, offset, 0.0);
    }
    // Baked into the vertices, so that f32 has already rounded them.
    for offset in [1e3, 1e4, 1e5] {
        furnace(1.0, 0.0, offset);
    }
}

#[test]
fn roulette_does_not_change_the_furnace() {
    let mut builder = seen(DVec3::new(0.3, 0.1, 0.2), DVec3::new(-1.0, 0.0, -1.0), 1.2);
    let wall = builder.material(matte(0.9, 1.0));
    builder.mesh("cube", inward_cube(), DAffine3::IDENTITY, wall);
    let scene = builder.build().unwrap();
    // Light sampling would only add its noise to that of the roulette.
    let strategy = dapple_integrator::settings::Strategy::BsdfOnly;
    let outcome = run(&scene, &Settings { max_bounces: 4000, strategy, ..settings(32, 256) });
    assert_close("furnace of albedo 0.9 with roulette", &outcome, 10.0);
}

#[test]
fn depth_counts_scattering_events() {
    let mut builder = seen(DVec3::new(0.3, 0.1, 0.2), DVec3::new(-1.0, 0.0, -1.0), 1.2);
    let wall = builder.material(matte(0.5, 1.0));
    builder.mesh("cube", inward_cube(), DAffine3::IDENTITY, wall);
    let scene = builder.build().unwrap();
    for n in 0..4 {
        let outcome =
            run(&scene, &Settings { max_bounces: n, ..settings(16, 64) }.with_path(|p| p.roulette = false));
        assert_close(&format!("{n} bounces"), &outcome, 2.0 - 0.5f64.powi(n as i32));
    }
}

#[test]
fn emitter_seen_directly_is_exact() {
    let mut builder = seen(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, 0.5);
    let light = builder.material(matte(0.0, 3.25));
    builder.mesh(
        "light",
        quad(Vec3::new(-2.0, -2.0, 0.0), Vec3::X * 4.0, Vec3::Y * 4.0),
        DAffine3::IDENTITY,
        light,
    );
    let outcome = run(&builder.build().unwrap(), &settings(8, 4));
    assert!(outcome.film.mean().pixels.iter().all(|p| *p == Vec3::splat(3.25)));
}

/// Corner form of a rectangle parallel to the receiver (docs/science.md, "Rectangles"): E = πL·C.
fn corner(x: f64, y: f64) -> f64 {
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / p * (y / p).atan() + y / q * (x / q).atan()) / (2.0 * PI)
}

#[test]
fn irradiance_under_a_quad_light() {
    for (half, height) in [(0.5, 1.0), (1e-3, 1.0), (5.0, 0.9)] {
        for pattern in [Pattern::Sobol, Pattern::Random, Pattern::Stratified] {
            let mut builder = irradiance_meter();
            let light = builder.material(matte(0.0, 2.0));
            let (h, y) = (half as f32, height as f32);
            builder.mesh(
                "light",
                quad(Vec3::new(-h, y, -h), Vec3::X * 2.0 * h, Vec3::Z * 2.0 * h),
                DAffine3::IDENTITY,
                light,
            );
            let scene = builder.build().unwrap();
            let outcome = run(&scene, &Settings { max_bounces: 1, pattern, ..settings(16, 64) });
            let exact = 2.0 * 4.0 * corner(half / height, half / height);
            assert_close(&format!("quad of half side {half}, {pattern}"), &outcome, exact);
        }
    }
}

/// E = πL(R/d)² for a sphere above the horizon, any size (docs/science.md, "Sphere lights").
#[test]
fn irradiance_under_a_sphere_light() {
    for radius in [0.9, 0.1, 1e-3, 1e-5] {
        let mut builder = irradiance_meter();
        let light = builder.material(matte(0.0, 1.0));
        // Outside the line of sight, which comes from (0.3, 0.8, 0.2).
        let d = DVec3::new(-0.4, 1.2, 0.0);
        builder.sphere("light", d, radius * 0.9, light);
        let scene = builder.build().unwrap();
        let outcome = run(&scene, &Settings { max_bounces: 1, ..settings(16, 64) });
        let (r, cos) = (radius * 0.9 / d.length(), d.y / d.length());
        assert_close(&format!("sphere of radius {radius}"), &outcome, r * r * cos);
    }
}

#[test]
fn irradiance_under_point_and_distant_lights() {
    let mut builder = irradiance_meter();
    builder.point_light(DVec3::new(-0.6, 2.0, 0.3), Vec3::splat(5.0), f64::INFINITY);
    let d = DVec3::new(-0.6, 2.0, 0.3);
    let outcome = run(&builder.build().unwrap(), &settings(8, 4));
    assert_close("point light", &outcome, 5.0 * d.y / d.length().powi(3) / PI);
    let mut builder = irradiance_meter();
    builder.distant_light(DVec3::new(0.0, 0.6, 0.8), Vec3::splat(2.0));
    assert_close("distant light", &run(&builder.build().unwrap(), &settings(8, 4)), 2.0 * 0.6 / PI);
}

#[test]
fn white_sky_over_a_convex_body_is_its_albedo() {
    let mut builder = seen(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 0.2);
    let body = builder.material(matte(0.5, 0.0));
    builder.sphere("ball", DVec3::ZERO, 1.0, body);
    builder.environment(Environment::constant(Vec3::ONE));
    assert_close("ball under a white sky", &run(&builder.build().unwrap(), &settings(16, 16)), 0.5);
}

#[test]
fn glass_in_a_white_sky_is_invisible() {
    let mut builder = seen(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 0.3);
    let mut glass = matte(1.0, 0.0);
    glass.base = dapple_materials::Material {
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        thin: false,
        ..Default::default()
    };
    let glass = builder.material(glass);
    builder.sphere("ball", DVec3::ZERO, 1.0, glass);
    builder.environment(Environment::constant(Vec3::ONE));
    let outcome = run(&builder.build().unwrap(), &Settings { max_bounces: 200, ..settings(16, 64) });
    assert_close("clear glass ball", &outcome, 1.0);
}
