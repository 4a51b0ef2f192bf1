//! Rough mirrors under a cap and under half a sky (docs/science.md, "Rough mirror and cap"), found by BSDF sampling
//! alone and with light sampling.

use crate::caps::{aimed_at, found_by_chance};
use crate::common::tracers::*;
use crate::common::*;
use dapple_integrator::Effect;
use dapple_lights::Environment;
use dapple_materials::Mirror;
use dapple_scene::{Scene, TexturedMaterial};
use dapple_testkit::closed_form::{ggx_cap, linear_edge};
use glam::{DAffine3, DVec2, DVec3, Vec3};
use std::f64::consts::FRAC_PI_2;

/// A perfectly reflecting rough metal under a disk.
fn metal_under(roughness: f32, theta: f64, disk: TexturedMaterial) -> Scene {
    under_a_cap(metal(Vec3::ONE, roughness), 1.0, theta, disk)
}

const CAPS: [(f32, f64); 4] = [(0.2, 0.05), (0.5, 0.4), (0.7, 0.9), (1.0, 1.2)];

#[test]
fn a_cap_found_by_chance() {
    for (roughness, theta) in CAPS {
        let exact = ggx_cap(f64::from(roughness).powi(2), theta);
        let scene = metal_under(roughness, theta, shadeless(1.0));
        found_by_chance(&format!("roughness {roughness}"), &scene, exact, Effect::Glossy, 1.0);
    }
}

/// The same emitter as a sampled light.
#[test]
fn a_cap_aimed_at() {
    for (roughness, theta) in CAPS {
        let exact = ggx_cap(f64::from(roughness).powi(2), theta);
        let scene = metal_under(roughness, theta, matte(0.0, 1.0));
        aimed_at(&format!("roughness {roughness}"), &scene, exact, Effect::Glossy);
    }
}

/// Below a black half-plane at a height of a ten-thousandth of its extent, half of a white sky remains visible.
#[test]
fn half_a_sky() {
    for roughness in [0.3f32, 0.7, 1.0] {
        let height = 1e-3;
        // Beside the diagonal of the metal: on an edge of a triangle the ray origin moves by a few error bounds, and so
        // does the visible part of the sky.
        let eye = DVec3::new(0.0, 3e-3, 0.5 * height);
        let mut builder = seen_in_parallel(eye, DVec3::NEG_Z, DVec3::Y, 1e-8);
        let rough = builder.material(metal(Vec3::ONE, roughness));
        let plane = quad(Vec3::new(-0.01, -0.01, 0.0), Vec3::X * 0.02, Vec3::Y * 0.02);
        builder.mesh("metal", plane, DAffine3::IDENTITY, rough);
        let black = builder.material(shadeless(0.0));
        let plane = half_plane(Vec3::Z * height as f32, [Vec3::X, Vec3::Y], DVec2::X, 0.0);
        builder.mesh("half-plane", plane, DAffine3::IDENTITY, black);
        builder.environment(Environment::constant(Vec3::ONE));
        let scene = builder.build().unwrap();
        let camera = scene.cameras[0].camera.clone();
        let exact = 0.5 * ggx_cap(f64::from(roughness).powi(2), FRAC_PI_2);
        for tracer in TRACERS {
            for pattern in UNBIASED {
                let settings = one_pixel(tracer, pattern, &[(Effect::Glossy, [4, 4])], 16);
                let moments = replicas(&scene, &camera, &settings, 1000)[0];
                let what = format!("roughness {roughness}, {tracer:?} {pattern}");
                assert_mean_known_to(&what, &moments, exact, 0.02 * exact);
            }
        }
    }
}

/// A bright half-plane over a blurred mirror, as a sampled light: the weights are correct only if the density of the
/// square is.
#[test]
fn an_edge_over_a_blurred_mirror_aimed_at() {
    let (blur, height, c, n) = (0.9, 0.5, 0.0817, DVec2::from_angle(0.6));
    for tilt in [0.0f64, 0.5, 0.9] {
        // Rays along −z hit a mirror rotated by half the tilt and leave at `tilt` to +z, in the plane of y and z.
        let r = DVec3::new(0.0, tilt.sin(), tilt.cos());
        let mut builder = seen_in_parallel(DVec3::Z * 0.2, DVec3::NEG_Z, DVec3::Y, 1e-6);
        let mirror = builder.material(blurred_mirror(blur as f32));
        let slope = Vec3::new(0.0, (0.5 * tilt).cos() as f32, -(0.5 * tilt).sin() as f32);
        let plane = quad((-Vec3::X - slope) * 0.01, Vec3::X * 0.02, slope * 0.02);
        builder.mesh("mirror", plane, DAffine3::IDENTITY, mirror);
        let bright = builder.material(TexturedMaterial { double_sided: true, ..matte(0.0, 1.0) });
        let side = DVec3::X.cross(r).as_vec3();
        let mut plane = half_plane((r * height).as_vec3(), [Vec3::X, side], n, c);
        // Close enough for light sampling to be effective.
        plane.positions.iter_mut().for_each(|p| *p = *p * 0.1 + (r * height).as_vec3() * 0.9);
        builder.mesh("light", plane, DAffine3::IDENTITY, bright);
        let scene = builder.build().unwrap();
        let camera = scene.cameras[0].camera.clone();
        let (extent, c) = (blur * height, 0.1 * c);
        let exact = linear_edge(&[n.x * extent, n.y * extent], c + 0.5 * (n.x + n.y) * extent);
        for tracer in TRACERS {
            for pattern in UNBIASED {
                let plans = [(Effect::Light, [4, 4]), (Effect::Glossy, [2, 2])];
                let settings = one_pixel(tracer, pattern, &plans, 16);
                let moments = replicas(&scene, &camera, &settings, 1500)[0];
                let what = format!("tilt {tilt}, {tracer:?} {pattern}");
                assert_mean_known_to(&what, &moments, exact, 0.02 * exact);
            }
        }
    }
}

/// Under a white sky only k_r is visible, whatever the blur.
#[test]
fn a_blurred_mirror_reflects_its_k_r() {
    for blur in [0.0, 0.4, 1.5] {
        let mut builder = seen_in_parallel(DVec3::Z, DVec3::NEG_Z, DVec3::Y, 1e-5);
        let mut mirror = blurred_mirror(blur);
        mirror.base.mirror = Some(Mirror { kr: Vec3::splat(0.35), blur });
        let mirror = builder.material(mirror);
        let plane = quad(Vec3::new(-0.01, -0.01, 0.0), Vec3::X * 0.02, Vec3::Y * 0.02);
        builder.mesh("mirror", plane, DAffine3::IDENTITY, mirror);
        builder.environment(Environment::constant(Vec3::ONE));
        let scene = builder.build().unwrap();
        let camera = scene.cameras[0].camera.clone();
        for tracer in TRACERS {
            for pattern in PATTERNS {
                let settings = one_pixel(tracer, pattern, &[(Effect::Glossy, [3, 3])], 9);
                let mean = values(&scene, &camera, &settings, 0)[0];
                assert!((mean - 0.35).abs() < 1e-6, "blur {blur}, {tracer:?} {pattern}: {mean}");
            }
        }
    }
}
