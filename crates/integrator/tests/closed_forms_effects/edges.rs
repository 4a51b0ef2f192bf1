//! A straight edge, blurred by all effects that move it linearly: pixel, square lens, motion, square gloss
//! (docs/science.md, "Linear edges").

use crate::common::moving::*;
use crate::common::tracers::*;
use crate::common::*;
use dapple_integrator::Effect;
use dapple_integrator::camera::{Aperture, Camera};
use dapple_sampling::Pattern;
use dapple_scene::Scene;
use dapple_testkit::closed_form::linear_edge;
use glam::{DAffine3, DVec2, DVec3, Vec3};

/// The visible indicator function is [Σ a_i (ξ_i − ½) ≤ c].
struct Edge {
    scene: Scene,
    camera: Camera,
    /// Two coefficients of each effect.
    a: Vec<(Effect, [f64; 2])>,
    c: f64,
}

impl Edge {
    fn coefficients(&self) -> Vec<f64> {
        self.a.iter().flat_map(|(_, a)| *a).collect()
    }

    fn exact(&self) -> f64 {
        let a = self.coefficients();
        linear_edge(&a, self.c + 0.5 * a.iter().sum::<f64>())
    }

    /// Mean over all combinations of `sides[i]` midpoints of coordinate i, and the share of those that are too close to
    /// the edge for f32.
    fn midpoints(&self, sides: &[u32]) -> (f64, f64) {
        let mut sums = vec![0.0];
        for (a, &n) in self.coefficients().iter().zip(sides) {
            let at = |i: u32| a * ((f64::from(i) + 0.5) / f64::from(n) - 0.5);
            sums = sums.iter().flat_map(|sum| (0..n).map(move |i| sum + at(i))).collect();
        }
        let share =
            |of: &dyn Fn(f64) -> bool| sums.iter().filter(|s| of(**s)).count() as f64 / sums.len() as f64;
        (share(&|sum| sum <= self.c), share(&|sum| (sum - self.c).abs() < 2e-5))
    }

    /// A coordinate and its midpoint differ by at most half a cell, all of them together by δ = Σ |a_i|/(2n_i): the
    /// share of the midpoints lies between V(c − δ) and V(c + δ).
    fn midpoint_range(&self, sides: &[u32]) -> [f64; 2] {
        let a = self.coefficients();
        let c = self.c + 0.5 * a.iter().sum::<f64>();
        let delta: f64 = a.iter().zip(sides).map(|(a, &n)| 0.5 * a.abs() / f64::from(n)).sum();
        [linear_edge(&a, c - delta), linear_edge(&a, c + delta)]
    }

    /// Checks these tracers with every pattern; nested with `side`² points per effect, otherwise with 64.
    #[track_caller]
    fn check(&self, what: &str, tracers: &[Tracer], side: u32) {
        let exact = self.exact();
        assert!((0.04..0.96).contains(&exact), "{what}: {exact} is inconclusive");
        let plans: Vec<_> = self.a.iter().map(|(effect, _)| (*effect, [side; 2])).collect();
        for &tracer in tracers {
            let side = if tracer == Tracer::Nested { side } else { 8 };
            let sides: Vec<u32> = self.a.iter().flat_map(|(effect, _)| sides_of(*effect, side)).collect();
            for pattern in PATTERNS {
                let settings = by_chance(one_pixel(tracer, pattern, &plans, 64));
                let deterministic =
                    pattern == Pattern::Grid && (tracer == Tracer::Nested || self.a.len() == 1);
                let n = if deterministic { 2 } else { 400 };
                let moments = replicas(&self.scene, &self.camera, &settings, n)[0];
                let (expected, floor) =
                    if pattern == Pattern::Grid { self.midpoints(&sides) } else { (exact, 0.0) };
                let what = format!("{what}, {tracer:?} {pattern}");
                assert!(moments.standard_error() < 0.01 && floor < 1e-3, "{what} is inconclusive");
                assert_mean(&what, &moments, expected, floor + 1e-6);
                if pattern == Pattern::Grid {
                    let [low, high] = self.midpoint_range(&sides);
                    assert!(low <= expected && expected <= high, "{what}: {low} {expected} {high}");
                }
                // Detects an error of one midpoint of the grid, one cell in 64.
                assert!(!deterministic || moments.standard_error() == 0.0, "{what}");
            }
        }
    }
}

/// Time is one-dimensional, and gets all points in that dimension.
fn sides_of(effect: Effect, side: u32) -> [u32; 2] {
    if effect == Effect::Time { [side * side, 1] } else { [side; 2] }
}

const SPAN: [Vec3; 2] = [Vec3::X, Vec3::Y];
/// For the perspective scenes: distance of the plane, tan(yfov/2).
const DISTANCE: f64 = 3.0;
const TAN: f64 = 0.125;

/// A camera at the origin looks along −z at the half-plane n·(x, y) ≤ c at z = −3.
fn in_perspective(n: DVec2, c: f64) -> Scene {
    let mut builder = seen(DVec3::ZERO, DVec3::NEG_Z, 2.0 * TAN.atan());
    let white = builder.material(shadeless(1.0));
    let plane = half_plane(Vec3::NEG_Z * DISTANCE as f32, SPAN, n, c);
    builder.mesh("half-plane", plane, DAffine3::IDENTITY, white);
    builder.build().unwrap()
}

/// The sum Σ a_i(ξ_i − ½) for the point of the plane that a film point sees through a square lens of half side
/// `radius`.
fn perspective_coefficients(n: DVec2, radius: f64, focus: f64) -> [(Effect, [f64; 2]); 2] {
    let pixel = 2.0 * TAN * DISTANCE;
    let lens = 2.0 * radius * (1.0 - DISTANCE / focus);
    [(Effect::Pixel, [n.x * pixel, -n.y * pixel]), (Effect::Lens, [n.x * lens, n.y * lens])]
}

fn towards(degrees: f64) -> DVec2 {
    DVec2::from_angle(degrees.to_radians())
}

#[test]
fn edge_under_the_pixel() {
    for (degrees, c) in [(0.0, 0.0711), (17.0, 0.1213), (45.0, -0.2031), (71.0, 0.3507), (90.0, -0.1033)] {
        let n = towards(degrees);
        let scene = in_perspective(n, c);
        let camera = scene.cameras[0].camera.clone();
        let a = vec![perspective_coefficients(n, 0.0, 1.0)[0]];
        Edge { scene, camera, a, c }.check(&format!("edge at {degrees}° under the pixel"), &TRACERS, 5);
    }
}

/// In front of the focal plane, behind it, and with the focus at infinity. (In paired mode the pixel takes part: see
/// below.)
#[test]
fn edge_through_a_square_lens() {
    let n = towards(33.0);
    for (focus, c) in [(1.7, -0.0613), (5.0, 0.0417), (f64::INFINITY, 0.0907)] {
        let scene = in_perspective(n, c);
        let camera = with_lens(&scene, Aperture::Square, 0.25, focus);
        let a = vec![perspective_coefficients(n, 0.25, focus)[1]];
        Edge { scene, camera, a, c }.check(&format!("focus at {focus}"), &[Tracer::Nested, Tracer::Path], 5);
    }
}

#[test]
fn edge_through_pixel_and_lens() {
    let n = towards(62.0);
    for (focus, c) in [(1.9, 0.1671), (4.4, -0.1219)] {
        let scene = in_perspective(n, c);
        let camera = with_lens(&scene, Aperture::Square, 0.4, focus);
        let a = perspective_coefficients(n, 0.4, focus).to_vec();
        Edge { scene, camera, a, c }.check(&format!("pixel and lens, focus at {focus}"), &TRACERS, 4);
    }
}

/// Parallel rays hit a blurred mirror at the origin at 45° and go up to the half-plane n·(x, z) ≤ c at `height`. About
/// R = +y the square spans u = n × R = −x and v = R × u = z.
#[test]
fn edge_in_a_blurred_mirror() {
    let (blur, height) = (0.6, 2.0);
    for (degrees, c) in [(0.0, 0.1931), (25.0, -0.2147), (68.0, 0.3011), (90.0, 0.1231)] {
        let n = towards(degrees);
        let mut builder = seen_in_parallel(DVec3::Z * 2.0, DVec3::NEG_Z, DVec3::Y, 1e-5);
        let mirror = builder.material(blurred_mirror(blur as f32));
        let slope = Vec3::new(0.0, 1.0, -1.0);
        let plane = quad((-Vec3::X - slope) * 0.5, Vec3::X, slope);
        builder.mesh("mirror", plane, DAffine3::IDENTITY, mirror);
        let white = builder.material(shadeless(1.0));
        let plane = half_plane(Vec3::Y * height as f32, [Vec3::X, Vec3::Z], n, c);
        builder.mesh("half-plane", plane, DAffine3::IDENTITY, white);
        let scene = builder.build().unwrap();
        let camera = scene.cameras[0].camera.clone();
        let a = vec![(Effect::Glossy, [n.x * blur * height, -n.y * blur * height])];
        Edge { scene, camera, a, c }.check(&format!("edge at {degrees}° in a blurred mirror"), &TRACERS, 6);
    }
}

/// Directions of the square below the surface carry nothing: cosθ + (½ − r)·l·sinθ > 0 remains of a white sky.
#[test]
fn blur_under_the_surface_is_lost() {
    let (blur, theta) = (0.8, 80f64.to_radians());
    let d = DVec3::new(theta.sin(), -theta.cos(), 0.0);
    let mut builder = seen_in_parallel(-d, d, DVec3::Z, 1e-5);
    let mirror = builder.material(blurred_mirror(blur as f32));
    let plane = quad(Vec3::new(-0.1, 0.0, 0.1), Vec3::X * 0.2, Vec3::Z * -0.2);
    builder.mesh("mirror", plane, DAffine3::IDENTITY, mirror);
    builder.environment(dapple_lights::Environment::constant(Vec3::ONE));
    let scene = builder.build().unwrap();
    let camera = scene.cameras[0].camera.clone();
    let a = vec![(Effect::Glossy, [0.0, blur * theta.sin()])];
    Edge { scene, camera, a, c: theta.cos() }.check("blur at 80°", &TRACERS, 6);
}

/// An edge that moves by `way` along x while the shutter is open, seen by parallel rays `half` to each side.
fn passing(n: DVec2, c: f64, way: f64, half: f64) -> Scene {
    let mut builder = seen_in_parallel(DVec3::Z * 2.0, DVec3::NEG_Z, DVec3::Y, half);
    builder.exposure(AT, SHUTTER);
    let white = builder.material(shadeless(1.0));
    let plane = half_plane(Vec3::ZERO, SPAN, n, c);
    builder.moving_mesh("half-plane", plane, slide(DVec3::X * way * -0.5, DVec3::X * way * 0.5), white);
    builder.build().unwrap()
}

/// The edge is at n·p ≤ c + n.x·way·(τ − ½).
#[test]
fn edge_that_moves() {
    for (degrees, c, way) in [(0.0, 0.1711, 1.0), (40.0, -0.1203, 0.8), (71.0, 0.0507, -2.0)] {
        let n = towards(degrees);
        let scene = passing(n, c, way, 1e-6);
        let camera = scene.cameras[0].camera.clone();
        let a = vec![(Effect::Time, [-n.x * way, 0.0])];
        let tracers = [Tracer::Nested, Tracer::Path];
        Edge { scene, camera, a, c }.check(&format!("edge at {degrees}° that moves"), &tracers, 6);
    }
}

/// Five dimensions: pixel, lens and time.
#[test]
fn edge_that_moves_through_pixel_and_lens() {
    let (half, radius) = (0.5, 0.3);
    for (degrees, c, way) in [(25.0, 0.2117, 0.9), (60.0, -0.3031, -1.7)] {
        let n = towards(degrees);
        let scene = passing(n, c, way, half);
        let camera = with_lens(&scene, Aperture::Square, radius, f64::INFINITY);
        let pair = |extent: f64| [n.x * extent, n.y * extent];
        let a = vec![
            (Effect::Pixel, pair(2.0 * half)),
            (Effect::Lens, pair(2.0 * radius)),
            (Effect::Time, [-n.x * way, 0.0]),
        ];
        Edge { scene, camera, a, c }.check(&format!("five dimensions, edge at {degrees}°"), &TRACERS, 3);
    }
}

/// All effects at once: six dimensions. Parallel rays through a lens focused at infinity are shifted by the lens as a
/// whole, and a mirror that faces them preserves distances.
#[test]
fn edge_through_pixel_lens_and_mirror() {
    let (half, radius, blur, height) = (0.5, 0.3, 0.3, 5.0);
    for (degrees, c) in [(20.0, 0.3127), (66.0, -0.4519)] {
        let n = towards(degrees);
        let mut builder = seen_in_parallel(DVec3::Z * 2.0, DVec3::NEG_Z, DVec3::Y, half);
        let mirror = builder.material(blurred_mirror(blur as f32));
        let plane = quad(Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0);
        builder.mesh("mirror", plane, DAffine3::IDENTITY, mirror);
        let white = builder.material(shadeless(1.0));
        let plane = half_plane(Vec3::Z * height as f32, SPAN, n, c);
        builder.mesh("half-plane", plane, DAffine3::IDENTITY, white);
        let scene = builder.build().unwrap();
        let camera = with_lens(&scene, Aperture::Square, radius, f64::INFINITY);
        let pair = |extent: f64| [n.x * extent, n.y * extent];
        let a = vec![
            (Effect::Pixel, pair(2.0 * half)),
            (Effect::Lens, pair(2.0 * radius)),
            (Effect::Glossy, pair(blur * height)),
        ];
        Edge { scene, camera, a, c }.check(&format!("six dimensions, edge at {degrees}°"), &TRACERS, 3);
    }
}
