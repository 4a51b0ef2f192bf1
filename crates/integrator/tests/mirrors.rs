//! A light seen in a flat mirror is the same light: its flux does not depend on where on the mirror reflected rays
//! start.

mod common;

use common::*;
use dapple_integrator::Settings;
use dapple_integrator::settings::MethodKind;
use dapple_scene::{CameraPose, Scene, SceneBuilder};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::f64::consts::PI;

const RADIUS: f64 = 0.005;
const FAR: f64 = 1000.0;
const YFOV: f64 = 2e-5;
const SIDE: u32 = 24;

/// A ball of 1e-5 rad, seen in a mirror whose diagonal is in the line of sight, with the scene rotated by `turn`.
fn seen_in_a_mirror(turn: DQuat, radiance: f32) -> Scene {
    let mut builder = SceneBuilder::new("test");
    builder.camera("eye", CameraPose::look_at(turn * DVec3::Z, DVec3::ZERO, turn * DVec3::Y, YFOV));
    let mirror = builder.material(metal(Vec3::ONE, 0.0));
    let plane = quad(Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0);
    builder.mesh("mirror", plane, DAffine3::from_quat(turn), mirror);
    let light = builder.material(matte(0.0, radiance));
    builder.sphere("light", turn * DVec3::Z * FAR, RADIUS, light);
    builder.build().unwrap()
}

#[test]
fn a_light_of_a_hundred_thousandth_keeps_its_flux_in_a_mirror() {
    let turns =
        [DQuat::IDENTITY, DQuat::from_rotation_z(0.3), DQuat::from_axis_angle(DVec3::ONE.normalize(), 0.8)];
    for turn in turns {
        let scene = seen_in_a_mirror(turn, 1.0);
        for method in [MethodKind::Path, MethodKind::Distribution] {
            let settings = Settings { size: (SIDE, SIDE), max_bounces: 1, ..Settings::default() }
                .with_method(method)
                .with_spp(64);
            let pixels = run(&scene, &settings).film.mean().pixels;
            let sum: f64 = pixels.iter().map(|p| f64::from(p.y)).sum();
            let radius = RADIUS / (FAR + 1.0) * f64::from(SIDE) / YFOV;
            let exact = PI * radius * radius;
            assert!((sum / exact - 1.0).abs() < 0.01, "{turn} {method:?}: {sum} of {exact}");
        }
    }
}
