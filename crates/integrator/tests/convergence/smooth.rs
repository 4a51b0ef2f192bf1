//! Smooth integrands: a plane lit by a point light, seen through pixel, lens and mirror; and a quad light.
//!
//! Expected slopes: random −1; in two dimensions −2 stratified and grid, about −2.9 Sobol; in one dimension −3, −4, −3.

use crate::common::moving::*;
use crate::common::tracers::*;
use crate::common::*;
use crate::edges::{any_direction, only};
use crate::study::*;
use dapple_integrator::camera::{Aperture, Camera};
use dapple_integrator::{Effect, Settings};
use dapple_lights::Environment;
use dapple_sampling::SampleSet;
use dapple_scene::Scene;
use dapple_testkit::closed_form::{flux_of_point_light, ggx_cap, parallel_rectangle, point_light_along_line};
use dapple_testkit::{Rng, quadrature};
use glam::{DAffine3, DVec2, DVec3, Vec3};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

const PLANE: [Option<f64>; 4] = [Some(-1.0), Some(-2.0), Some(-2.0), Some(-2.88)];
const KINK: [Option<f64>; 4] = [Some(-1.0), Some(-2.0), Some(-2.0), Some(-2.54)];
const LINE: [Option<f64>; 4] = [Some(-1.0), Some(-3.0), Some(-4.0), Some(-3.0)];

/// Height of the point light over the plane, and its position.
const HEIGHT: f64 = 0.6;

/// Parallel rays down to z = 0 and a white plane there, or, with a mirror, a blurred mirror at z = 0 under the plane at
/// z = 5. A point light illuminates it from `light` in the plane. Pixel, lens and blur each move the image over a unit
/// square.
pub fn lit_plane(light: DVec2, mirrored: bool) -> (Scene, Camera) {
    let mut builder = seen_in_parallel(DVec3::Z * 2.0, DVec3::NEG_Z, DVec3::Y, 0.5);
    let white = builder.material(matte(1.0, 0.0));
    let plane = quad(Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0);
    if mirrored {
        let mirror = builder.material(blurred_mirror(0.2));
        builder.mesh("mirror", plane, DAffine3::IDENTITY, mirror);
        let above = quad(Vec3::new(-9.0, -9.0, 5.0), Vec3::Y * 18.0, Vec3::X * 18.0);
        builder.mesh("plane", above, DAffine3::IDENTITY, white);
        builder.point_light(light.extend(5.0 - HEIGHT), Vec3::ONE, f64::INFINITY);
    } else {
        builder.mesh("plane", plane, DAffine3::IDENTITY, white);
        builder.point_light(light.extend(HEIGHT), Vec3::ONE, f64::INFINITY);
    }
    let scene = builder.build().unwrap();
    let camera = with_lens(&scene, Aperture::Square, 0.5, f64::INFINITY);
    (scene, camera)
}

/// The camera shifted by about `by` (world units), and the exact shift.
pub fn moved(scene: &Scene, camera: &Camera, by: DVec3) -> (Camera, DVec3) {
    let scale = scene.space.scale;
    let origin = camera.origin + (by * scale).as_vec3();
    (Camera { origin, ..camera.clone() }, (origin - camera.origin).as_dvec3() / scale)
}

/// Mean radiance of the unit square about `middle`.
pub fn mean_radiance(middle: DVec2, light: DVec2) -> f64 {
    let low = middle - light - DVec2::splat(0.5);
    flux_of_point_light(low, low + DVec2::ONE, HEIGHT) * FRAC_1_PI
}

/// A random shift of up to `reach` in either direction.
pub fn somewhere(seed: u64, reach: f64) -> DVec3 {
    let mut rng = Rng::new(seed);
    DVec3::new(rng.f64() * 2.0 - 1.0, rng.f64() * 2.0 - 1.0, 0.0) * reach
}

fn plane_through(name: &str, effect: Effect, effort: Effort) {
    let mirrored = effect == Effect::Glossy;
    // Outside the mirror's blur, which would show the light itself.
    let light = if mirrored { DVec2::new(0.95, 0.75) } else { DVec2::new(0.3, 0.2) };
    let (scene, camera) = lit_plane(light, mirrored);
    let error = |plan: SampleSet, seed: u64| {
        let (camera, p) = moved(&scene, &camera, somewhere(seed, if mirrored { 0.2 } else { 0.6 }));
        let settings = Settings { max_bounces: 2, ..only(effect, plan) };
        values(&scene, &camera, &settings, seed)[0] - mean_radiance(p.truncate(), light)
    };
    Study { name, layout: Layout::Square, counts: effort.counts(), expected: PLANE, error: &error }
        .check(effort);
}

/// A quad light of this size at 0.8 above the floor; the position of the floor moves along `freedom`.
fn quad_light(name: &str, size: DVec2, freedom: DVec3, layout: Layout, effort: Effort) {
    let (height, bright) = (0.8, (0.8 / size.y) as f32);
    let mut builder = seen_in_parallel(DVec3::Z * 0.2, DVec3::NEG_Z, DVec3::Y, 1e-6);
    let white = builder.material(matte(1.0, 0.0));
    let floor = quad(Vec3::new(-2.0, -2.0, 0.0), Vec3::X * 4.0, Vec3::Y * 4.0);
    builder.mesh("floor", floor, DAffine3::IDENTITY, white);
    let bright_material = builder.material(matte(0.0, bright));
    let half = (size * 0.5).as_vec2();
    // Faces down: y before x.
    let corner = Vec3::new(-half.x, half.y, height as f32);
    let light = quad(corner, Vec3::X * 2.0 * half.x, Vec3::NEG_Y * 2.0 * half.y);
    builder.mesh("light", light, DAffine3::IDENTITY, bright_material);
    let scene = builder.build().unwrap();
    let camera = scene.cameras[0].camera.clone();
    let error = |plan: SampleSet, seed: u64| {
        let (camera, p) = moved(&scene, &camera, somewhere(seed, 0.5) * freedom);
        let (p, half) = (p.truncate(), half.as_dvec2());
        let exact = f64::from(bright) * parallel_rectangle(-half - p, half - p, height);
        values(&scene, &camera, &only(Effect::Light, plan), seed)[0] - exact
    };
    let (counts, expected) = match layout {
        Layout::Square => (effort.counts(), PLANE),
        _ => (effort.counts_on_a_line(), LINE),
    };
    Study { name, layout, counts, expected, error: &error }.check(effort);
}

/// A small floor at the centre of a sphere of albedo ½ with a point light beside it, in the plane of the floor: the
/// light that the sphere reflects is smooth in the projection of its direction, (1 − l·p)/(1 + l² − 2l·p)^{3/2}/2π; in
/// the square it has kinks along the diagonals, which come from the map to the disk.
fn dome(effort: Effort) {
    let error = |plan: SampleSet, seed: u64| {
        let mut rng = Rng::new(seed);
        let light = any_direction(&mut rng) * (0.2 + 0.3 * rng.f64());
        let mut builder = seen_in_parallel(DVec3::Z * 0.2, DVec3::NEG_Z, DVec3::Y, 1e-6);
        let white = builder.material(matte(1.0, 0.0));
        let floor = quad(Vec3::new(-0.01, -0.01, 0.0), Vec3::X * 0.02, Vec3::Y * 0.02);
        builder.mesh("floor", floor, DAffine3::IDENTITY, white);
        let grey = builder.material(matte(0.5, 0.0));
        builder.sphere("sphere", DVec3::ZERO, 1.0, grey);
        builder.point_light(light.extend(0.0), Vec3::ONE, f64::INFINITY);
        let scene = builder.build().unwrap();
        let given = |r: f64, phi: f64| {
            let along = light.length() * r * phi.cos();
            r * (1.0 - along) / (1.0 + light.length_squared() - 2.0 * along).powf(1.5)
        };
        let sum = quadrature::rectangle(given, [0.0; 2], [1.0, PI], 1e-8);
        let settings = Settings { max_bounces: 2, ..only(Effect::Diffuse, plan) };
        let exact = sum * FRAC_1_PI * FRAC_1_PI;
        values(&scene, &scene.cameras[0].camera, &settings, seed)[0] - exact
    };
    let name = "smooth, diffuse";
    Study { name, layout: Layout::Square, counts: effort.counts(), expected: KINK, error: &error }
        .check(effort);
}

/// A point light that moves along x while the shutter is open, over a plane.
fn passing_light(effort: Effort) {
    let error = |plan: SampleSet, seed: u64| {
        let mut builder = seen_in_parallel(DVec3::Z * 0.2, DVec3::NEG_Z, DVec3::Y, 1e-6);
        builder.exposure(AT, SHUTTER);
        let white = builder.material(matte(1.0, 0.0));
        let floor = quad(Vec3::new(-1.0, -1.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0);
        builder.mesh("floor", floor, DAffine3::IDENTITY, white);
        let from = somewhere(seed, 0.5) + DVec3::new(-0.5, 0.0, HEIGHT);
        builder.point_light(DVec3::ZERO, Vec3::ONE, f64::INFINITY);
        builder.moving_light(slide(from, from + DVec3::X));
        let scene = builder.build().unwrap();
        let exact = point_light_along_line(from.x, from.x + 1.0, from.y, HEIGHT) * FRAC_1_PI;
        values(&scene, &scene.cameras[0].camera, &only(Effect::Time, plan), seed)[0] - exact
    };
    let name = "1-D smooth, time";
    Study { name, layout: Layout::Line, counts: effort.counts_on_a_line(), expected: LINE, error: &error }
        .check(effort);
}

/// A rough mirror or a rough thin wall of random roughness in white surroundings: only the masking of its facets
/// remains. (Refraction would not be smooth: facets seen at grazing angles introduce a square root in the second
/// coordinate.)
fn all_around(name: &str, effect: Effect, effort: Effort) {
    let error = |plan: SampleSet, seed: u64| {
        let roughness = 0.85 + 0.15 * Rng::new(seed).f64() as f32;
        let alpha = f64::from(roughness).powi(2);
        let surface = match effect {
            Effect::Glossy => metal(Vec3::ONE, roughness),
            _ => clear(roughness, 1.0),
        };
        let mut builder = seen_in_parallel(DVec3::Z, DVec3::NEG_Z, DVec3::Y, 1e-5);
        let rough = builder.material(surface);
        let plane = quad(Vec3::new(-0.01, -0.01, 0.0), Vec3::X * 0.02, Vec3::Y * 0.02);
        builder.mesh("surface", plane, DAffine3::IDENTITY, rough);
        builder.environment(Environment::constant(Vec3::ONE));
        let scene = builder.build().unwrap();
        values(&scene, &scene.cameras[0].camera, &only(effect, plan), seed)[0] - ggx_cap(alpha, FRAC_PI_2)
    };
    let (layout, counts) = (Layout::Column, effort.counts_on_a_line());
    Study { name, layout, counts, expected: LINE, error: &error }.check(effort);
}

fn in_the_plane(effort: Effort) {
    plane_through("smooth, pixel", Effect::Pixel, effort);
    plane_through("smooth, lens", Effect::Lens, effort);
    plane_through("smooth, square gloss", Effect::Glossy, effort);
    quad_light("smooth, quad light", DVec2::new(0.9, 0.7), DVec3::ONE, Layout::Square, effort);
    dome(effort);
}

/// So narrow that only its length matters, which is the second coordinate.
fn on_a_line(effort: Effort) {
    quad_light("1-D smooth, narrow light", DVec2::new(1.2, 1e-3), DVec3::X, Layout::Column, effort);
    passing_light(effort);
    all_around("1-D smooth, GGX gloss", Effect::Glossy, effort);
    all_around("1-D smooth, rough thin wall", Effect::Refract, effort);
}

#[test]
fn smooth_planes() {
    in_the_plane(QUICK);
}

#[test]
fn smooth_lines() {
    on_a_line(QUICK);
}

#[test]
#[ignore = "the long table: minutes"]
fn smooth_in_full() {
    in_the_plane(FULL);
    on_a_line(FULL);
}
