//! The shadow of a straight edge under a quad light: the whole profile, and its width w·h/(H − h)
//! (docs/science.md, "Penumbra").

use crate::common::maps::midpoint_bound;
use crate::common::tracers::*;
use crate::common::*;
use dapple_integrator::{Effect, Settings};
use dapple_sampling::Pattern;
use dapple_scene::Scene;
use dapple_testkit::closed_form::{parallel_rectangle, penumbra_width};
use glam::{DAffine3, DVec2, DVec3, Vec3};
use std::f64::consts::FRAC_1_PI;

/// Width and length of the light, its height, the edge's height, radiance.
const W: f64 = 0.5;
const LENGTH: f64 = 0.8;
const HEIGHT: f64 = 1.5;
const EDGE: f64 = 0.6;
const L: f64 = 2.0;

/// A row of points on the floor, x = −0.25 … 0.25, one and a half times as wide as the penumbra.
const POINTS: u32 = 100;
const PITCH: f64 = 0.005;

fn place(i: usize) -> f64 {
    (i as f64 + 0.5 - 0.5 * f64::from(POINTS)) * PITCH
}

/// A white floor, a light above, and between them the black half-plane x < 0. The camera looks down from below it.
fn shadow(occluded: bool) -> Scene {
    let half_height = 0.5 * PITCH;
    let mut builder = seen_in_parallel(DVec3::Y * 0.1, DVec3::NEG_Y, DVec3::NEG_Z, half_height);
    let white = builder.material(matte(1.0, 0.0));
    let floor = quad(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::Z * -2.0);
    builder.mesh("floor", floor, DAffine3::IDENTITY, white);
    let bright = builder.material(matte(0.0, L as f32));
    let corner = Vec3::new(-0.5 * W as f32, HEIGHT as f32, -0.5 * LENGTH as f32);
    let light = quad(corner, Vec3::X * W as f32, Vec3::Z * LENGTH as f32);
    builder.mesh("light", light, DAffine3::IDENTITY, bright);
    if occluded {
        let black = builder.material(matte(0.0, 0.0));
        let plane = quad(Vec3::new(-5.0, EDGE as f32, -5.0), Vec3::X * 5.0, Vec3::Z * 10.0);
        builder.mesh("half-plane", plane, DAffine3::IDENTITY, black);
    }
    builder.build().unwrap()
}

/// Radiance of the floor at (p, 0, 0), from where the part x > −p(H − h)/h of the light is visible.
fn exact(p: f64) -> f64 {
    let seen_from = (-p * (HEIGHT - EDGE) / EDGE).clamp(-0.5 * W, 0.5 * W);
    let (low, high) = (DVec2::new(seen_from, -0.5 * LENGTH), DVec2::new(0.5 * W, 0.5 * LENGTH));
    L * parallel_rectangle(low - DVec2::X * p, high - DVec2::X * p, HEIGHT)
}

fn row(tracer: Tracer, pattern: Pattern, side: u32) -> Settings {
    Settings { size: (POINTS, 1), ..one_pixel(tracer, pattern, &[(Effect::Light, [side; 2])], side * side) }
}

#[test]
fn the_whole_profile() {
    let scene = shadow(true);
    let camera = scene.cameras[0].camera.clone();
    let full = exact(place(99));
    for tracer in [Tracer::Nested, Tracer::Path] {
        for pattern in UNBIASED {
            let profile = replicas(&scene, &camera, &row(tracer, pattern, 4), 200);
            let mut sum = 0.0;
            for (i, moments) in profile.iter().enumerate() {
                let (p, exact) = (place(i), exact(place(i)));
                let what = format!("{tracer:?} {pattern}, x = {p}");
                assert_mean_known_to(&what, moments, exact, 0.015 * full);
                if exact > 0.0 {
                    sum += (moments.mean - exact) / full;
                }
            }
            // A small common bias, which no single point reveals: 100 points, each known to 1 %.
            assert!(sum.abs() / 100.0 < 0.004, "{tracer:?} {pattern}: {}", sum / 100.0);
        }
    }
}

/// In paired mode the pixel is sampled as well: its mean is over the pixel, within which the profile is nearly linear,
/// except where it begins and ends.
#[test]
fn the_profile_of_paired_pixels() {
    let scene = shadow(true);
    let camera = scene.cameras[0].camera.clone();
    for pattern in PATTERNS {
        let profile = replicas(&scene, &camera, &row(Tracer::Paired, pattern, 4), 200);
        for (i, moments) in profile.iter().enumerate() {
            let p = place(i);
            let mean = 0.25 * (exact(p - 0.5 * PITCH) + 2.0 * exact(p) + exact(p + 0.5 * PITCH));
            // The kernel decreases by less than 2L·w·l/(πH²)·(1/H + 1/h) per unit of p; the error of the trapezoid rule
            // is below a quarter of the change over the pixel. A grid of 4×4 errs by its bound.
            let bound = if pattern == Pattern::Grid { grid_bound(4) } else { 0.0 };
            assert_mean(&format!("{pattern}, x = {p}"), moments, mean, bound + 5e-4);
        }
    }
}

/// Over the surface cosθ·cosθ'/d² ≤ 1/H² rises and falls once along a line, and the edge cuts off one side.
fn grid_bound(side: u32) -> f64 {
    let most = L * W * LENGTH / (HEIGHT * HEIGHT) * FRAC_1_PI;
    midpoint_bound([2.0 * most; 2], [side; 2])
}

/// Paths sample uniformly in solid angle: the variations there, with the coordinates in either order.
fn aimed_bound(p: f64, side: u32) -> f64 {
    let corner = DVec3::new(-0.5 * W - p, HEIGHT, -0.5 * LENGTH);
    let (e1, e2) = (DVec3::X * W, DVec3::Z * LENGTH);
    let bound = |(e1, e2)| {
        let (omega, direction) = maps::rectangle_in_solid_angle(corner, e1, e2);
        let seen = |d: DVec3| p + d.x * (EDGE / d.y) > 0.0;
        let integrand = |u, v| {
            let d: DVec3 = direction(u, v);
            L * FRAC_1_PI * omega * d.y * f64::from(seen(d))
        };
        midpoint_bound(maps::variations(integrand), [side; 2])
    };
    [(e1, e2), (e2, e1)].map(bound).into_iter().fold(0.0, f64::max)
}

#[test]
fn the_profile_of_a_grid() {
    let scene = shadow(true);
    let camera = scene.cameras[0].camera.clone();
    for tracer in [Tracer::Nested, Tracer::Path] {
        let profile = values(&scene, &camera, &row(tracer, Pattern::Grid, 64), 0);
        for (i, value) in profile.iter().enumerate().step_by(if tracer == Tracer::Path { 5 } else { 1 }) {
            let p = place(i);
            let bound = if tracer == Tracer::Path { aimed_bound(p, 64) } else { grid_bound(64) };
            let exact = exact(p);
            assert!((value - exact).abs() <= bound + 1e-6, "{tracer:?}, x = {p}: {value} {exact} {bound}");
        }
    }
}

/// Umbra: black. Lit: the bits of the image without the half-plane. In between, neither; the width is w·h/(H − h).
#[test]
fn the_width() {
    let (with, without) = (shadow(true), shadow(false));
    let width = penumbra_width(W, EDGE, HEIGHT);
    for tracer in [Tracer::Nested, Tracer::Path] {
        for pattern in PATTERNS {
            let settings = row(tracer, pattern, 32);
            let [shaded, lit] = [&with, &without].map(|scene| {
                // The half-plane changes render space: only there lengths agree bit for bit.
                let camera = scene.cameras[0].camera.clone();
                values(scene, &camera, &settings, 3)
            });
            let dark = shaded.iter().filter(|&&v| v == 0.0).count();
            let bright = shaded.iter().zip(&lit).filter(|(a, b)| (*a / *b - 1.0).abs() < 1e-5).count();
            let measured = (POINTS as usize - dark - bright) as f64 * PITCH;
            // A point of 1024 may miss the last 1/32 of the light on either side.
            let short = width / 32.0;
            assert!(
                measured <= width + PITCH && measured >= width - 2.0 * short - PITCH,
                "{tracer:?} {pattern}: {measured} of {width}"
            );
            for (i, value) in shaded.iter().enumerate() {
                assert!(place(i) > -0.5 * width || *value == 0.0, "{tracer:?} {pattern}: light in the umbra");
            }
        }
    }
}
