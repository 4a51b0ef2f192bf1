//! Edges: the boundary of a visible object crosses the domain of one integral.
//!
//! Expected slopes: random −1; oblique edges −1.5 for all three others; axis-aligned ones at a random position −1.5
//! stratified, −1 grid, −2 Sobol in two dimensions and −2 for all three in one.

use crate::common::moving::*;
use crate::common::tracers::*;
use crate::common::*;
use crate::study::*;
use dapple_integrator::camera::{Aperture, Camera};
use dapple_integrator::{Effect, Settings};
use dapple_sampling::{Pattern, SampleSet};
use dapple_scene::Scene;
use dapple_testkit::Rng;
use dapple_testkit::closed_form::{clipped, ggx_cap, ggx_refracted_cap, linear_edge, polygon};
use glam::{DAffine3, DVec2, DVec3, Vec3};
use std::f64::consts::TAU;

const OBLIQUE: [Option<f64>; 4] = [Some(-1.0), Some(-1.5), Some(-1.5), Some(-1.5)];
const ALIGNED: [Option<f64>; 4] = [Some(-1.0), Some(-1.5), Some(-1.0), Some(-2.0)];
const STEP: [Option<f64>; 4] = [Some(-1.0), Some(-2.0), Some(-2.0), Some(-2.0)];

/// Only `effect` is on, with these points.
pub fn only(effect: Effect, plan: SampleSet) -> Settings {
    let mut settings = one_pixel(Tracer::Nested, plan.pattern, &[], 1);
    *settings.plans.of_mut(effect) = plan;
    if effect == Effect::Light { settings } else { by_chance(settings) }
}

/// Parallel rays down to z = 0 and the half-plane n·(x, y) ≤ c there, or, with a mirror, to a blurred mirror at z = 0
/// under the half-plane at z = 5. Pixel, lens and blur each move the image over a unit square.
pub fn half_plane_seen(n: DVec2, c: f64, mirrored: bool) -> (Scene, Camera) {
    let mut builder = seen_in_parallel(DVec3::Z * 2.0, DVec3::NEG_Z, DVec3::Y, 0.5);
    let white = builder.material(shadeless(1.0));
    let z = if mirrored { 5.0 } else { 0.0 };
    let plane = half_plane(Vec3::Z * z, [Vec3::X, Vec3::Y], n, c);
    builder.mesh("half-plane", plane, DAffine3::IDENTITY, white);
    if mirrored {
        let mirror = builder.material(blurred_mirror(0.2));
        let plane = quad(Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0);
        builder.mesh("mirror", plane, DAffine3::IDENTITY, mirror);
    }
    let scene = builder.build().unwrap();
    let camera = with_lens(&scene, Aperture::Square, 0.5, f64::INFINITY);
    (scene, camera)
}

/// A random direction: over positions and directions of an edge, the squared error of a grid decreases as N^−1.5; for a
/// single direction it depends on how well its slope is approximated by fractions.
pub fn any_direction(rng: &mut Rng) -> DVec2 {
    DVec2::from_angle(TAU * rng.f64())
}

fn under_an_edge(name: &str, effect: Effect, oblique: bool, layout: Layout, effort: Effort) {
    let error = |plan: SampleSet, seed: u64| {
        let mut rng = Rng::new(seed);
        let n = if oblique { any_direction(&mut rng) } else { DVec2::X };
        // At any position in the square.
        let c = (rng.f64() - 0.5) * 0.8 * (n.x.abs() + n.y.abs());
        let (scene, camera) = half_plane_seen(n, c, effect == Effect::Glossy);
        let exact = linear_edge(&[n.x, n.y], c + 0.5 * (n.x + n.y));
        values(&scene, &camera, &only(effect, plan), seed)[0] - exact
    };
    let expected = match layout {
        Layout::Square if oblique => OBLIQUE,
        Layout::Square => ALIGNED,
        _ => STEP,
    };
    Study { name, layout, counts: effort.counts(), expected, error: &error }.check(effort);
}

/// An edge between a quad light and the floor.
fn shadow(effort: Effort) {
    let (height, at) = (1.2, 0.5);
    let corner = DVec3::new(-0.5, -0.4, height);
    let (u, v) = (DVec3::Y * 0.8, DVec3::X * 0.9);
    let error = |plan: SampleSet, seed: u64| {
        let mut rng = Rng::new(seed);
        let n = any_direction(&mut rng);
        // The centre of the penumbra is at the visible point of the floor.
        let c = (rng.f64() - 0.5) * 0.3;
        let mut builder = seen_in_parallel(DVec3::Z * 0.2, DVec3::NEG_Z, DVec3::Y, 1e-6);
        let white = builder.material(matte(1.0, 0.0));
        let floor = quad(Vec3::new(-1.0, -1.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0);
        builder.mesh("floor", floor, DAffine3::IDENTITY, white);
        let bright = builder.material(matte(0.0, 1.0));
        let light = quad(corner.as_vec3(), u.as_vec3(), v.as_vec3());
        builder.mesh("light", light, DAffine3::IDENTITY, bright);
        let black = builder.material(matte(0.0, 0.0));
        let plane = half_plane(Vec3::Z * at as f32, [Vec3::X, Vec3::Y], n, c);
        builder.mesh("half-plane", plane, DAffine3::IDENTITY, black);
        let scene = builder.build().unwrap();
        let camera = scene.cameras[0].camera.clone();
        // The point at which the segment to a point of the light crosses the plane of the edge.
        let corners = [corner, corner + u, corner + u + v, corner + v];
        let seen = clipped(&corners, |s| n.dot((s * (at / height)).truncate()) - c);
        let exact = if seen.len() < 3 { 0.0 } else { polygon(&seen) };
        values(&scene, &camera, &only(Effect::Light, plan), seed)[0] - exact
    };
    let name = "shadow edge, light";
    Study { name, layout: Layout::Square, counts: effort.counts(), expected: OBLIQUE, error: &error }
        .check(effort);
}

/// Extent of the half-plane of [`ceiling`] in units of its height. The map of the diffuse lobe takes the horizon to the
/// sides of its square, so that far sides of the half-plane are edges along the grid, in cells whose centres lie above:
/// a share of about 1/(2·reach²) that no grid sees, as an error independent of N. With an extent of 20 it was 1.2e-3,
/// twice the error that the near edge leaves at N = 4096, and the slope of the grid was −1.17; here it is 5e-6.
const REACH: f32 = 300.0;

/// A bright half-plane above a floor, found by BSDF sampling: its edge is a curve in the square of a diffuse lobe.
fn ceiling(effort: Effort) {
    let error = |plan: SampleSet, seed: u64| {
        let mut rng = Rng::new(seed);
        let (n, c) = (any_direction(&mut rng), rng.f64());
        let mut builder = seen_in_parallel(DVec3::Z * 0.2, DVec3::NEG_Z, DVec3::Y, 1e-6);
        let white = builder.material(matte(1.0, 0.0));
        let floor = quad(Vec3::new(-0.1, -0.1, 0.0), Vec3::X * 0.2, Vec3::Y * 0.2);
        builder.mesh("floor", floor, DAffine3::IDENTITY, white);
        let bright = builder.material(shadeless(1.0));
        let plane = half_plane_up_to(REACH, Vec3::Z, [Vec3::X, Vec3::Y], n, c);
        let corners: Vec<DVec3> = plane.positions.iter().map(|p| p.as_dvec3()).collect();
        builder.mesh("half-plane", plane, DAffine3::IDENTITY, bright);
        let scene = builder.build().unwrap();
        let camera = scene.cameras[0].camera.clone();
        values(&scene, &camera, &only(Effect::Diffuse, plan), seed)[0] - polygon(&corners)
    };
    let name = "edge of a ceiling, diffuse";
    Study { name, layout: Layout::Square, counts: effort.counts(), expected: OBLIQUE, error: &error }
        .check(effort);
}

/// A rough surface in front of a cap of random size: a step in the second coordinate, with a smoothly decreasing
/// weight.
fn cap(name: &str, effect: Effect, layout: Layout, expected: [Option<f64>; 4], effort: Effort) {
    let alpha = f64::from(0.8f32).powi(2);
    let error = |plan: SampleSet, seed: u64| {
        let share = Rng::new(seed).f64();
        let (scene, exact) = match effect {
            Effect::Glossy => {
                let theta = 0.25 + 0.8 * share;
                let scene = under_a_cap(metal(Vec3::ONE, 0.8), 1.0, theta, shadeless(1.0));
                (scene, ggx_cap(alpha, theta))
            }
            _ => {
                let theta = 0.1 + 0.35 * share;
                let scene = under_a_cap(clear(0.8, 1.5), -1.0, theta, shadeless(1.0));
                (scene, ggx_refracted_cap(alpha, 1.5, theta))
            }
        };
        values(&scene, &scene.cameras[0].camera, &only(effect, plan), seed)[0] - exact
    };
    Study { name, layout, counts: effort.counts(), expected, error: &error }.check(effort);
}

/// A half-plane that passes the pixel centre at a random time: 0.8 of the shutter interval wide.
fn passing(effort: Effort) {
    let error = |plan: SampleSet, seed: u64| {
        let share = 0.1 + 0.8 * Rng::new(seed).f64();
        let mut builder = seen_in_parallel(DVec3::Z, DVec3::NEG_Z, DVec3::Y, 1e-6);
        builder.exposure(AT, SHUTTER);
        let white = builder.material(shadeless(1.0));
        let plane = half_plane(Vec3::ZERO, [Vec3::X, Vec3::Y], DVec2::X, 0.0);
        // It reaches the pixel centre after `share` of the time, and covers it from then on.
        let way = slide(DVec3::X * -share, DVec3::X * (1.0 - share));
        builder.moving_mesh("half-plane", plane, way, white);
        let scene = builder.build().unwrap();
        values(&scene, &scene.cameras[0].camera, &only(Effect::Time, plan), seed)[0] - (1.0 - share)
    };
    Study {
        name: "1-D step, time",
        layout: Layout::Line,
        counts: effort.counts(),
        expected: STEP,
        error: &error,
    }
    .check(effort);
}

fn oblique(effort: Effort) {
    for (name, effect) in [
        ("oblique edge, pixel", Effect::Pixel),
        ("oblique edge, lens", Effect::Lens),
        ("oblique edge, square gloss", Effect::Glossy),
    ] {
        under_an_edge(name, effect, true, Layout::Square, effort);
    }
    shadow(effort);
    ceiling(effort);
}

fn aligned(effort: Effort) {
    for (name, effect) in [
        ("aligned edge, pixel", Effect::Pixel),
        ("aligned edge, lens", Effect::Lens),
        ("aligned edge, square gloss", Effect::Glossy),
    ] {
        under_an_edge(name, effect, false, Layout::Square, effort);
    }
    cap("cap, GGX gloss", Effect::Glossy, Layout::Square, ALIGNED, effort);
    cap("cap, rough refraction", Effect::Refract, Layout::Square, ALIGNED, effort);
}

fn on_a_line(effort: Effort) {
    under_an_edge("1-D step, pixel", Effect::Pixel, false, Layout::Line, effort);
    under_an_edge("1-D step, lens", Effect::Lens, false, Layout::Line, effort);
    passing(effort);
    cap("1-D cap, GGX gloss", Effect::Glossy, Layout::Column, STEP, effort);
    cap("1-D cap, rough refraction", Effect::Refract, Layout::Column, STEP, effort);
}

#[test]
fn oblique_edges() {
    oblique(QUICK);
}

#[test]
fn aligned_edges() {
    aligned(QUICK);
}

#[test]
fn steps_on_a_line() {
    on_a_line(QUICK);
}

#[test]
#[ignore = "the long table: minutes"]
fn edges_in_full() {
    oblique(FULL);
    aligned(FULL);
    on_a_line(FULL);
}

/// The MSE of random points is the variance V(1 − V)/N: checks the constant, not only the slope.
#[test]
fn random_edges_have_their_variance() {
    let n = DVec2::from_angle(0.6);
    let (scene, camera) = half_plane_seen(n, 0.0, false);
    let share = linear_edge(&[n.x, n.y], 0.5 * (n.x + n.y));
    assert!((share - 0.5).abs() < 1e-12);
    let plan = SampleSet::new(16, Pattern::Random);
    let moments = replicas(&scene, &camera, &only(Effect::Pixel, plan), 4000)[0];
    // The relative variance of the variance of nearly normal values is 2/R.
    let ratio = moments.variance() / (0.25 / 16.0);
    assert!((ratio - 1.0).abs() < 4.0 * (2.0f64 / 4000.0).sqrt(), "{ratio}");
}
