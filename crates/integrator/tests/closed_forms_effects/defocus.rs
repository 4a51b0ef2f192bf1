//! Defocus: an edge seen through a round lens, and a small patch whose light is spread without loss (docs/science.md,
//! "Thin lens").

use crate::common::tracers::*;
use crate::common::*;
use dapple_integrator::camera::{Aperture, Camera};
use dapple_integrator::{Effect, Settings};
use dapple_sampling::{Moments, Pattern};
use dapple_scene::Scene;
use dapple_testkit::closed_form::{blur_diameter, disk_beside_line};
use dapple_testkit::quadrature;
use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};

const DISTANCE: f64 = 3.0;
const RADIUS: f64 = 0.2;

/// A row of 64 pixel centres looks at the edge x = 0 of a half-plane at z = −3 that is blurred over 40 pixels.
fn blurred_edge(focus: f64) -> (Scene, Camera) {
    let tan = blur_diameter(2.0 * RADIUS, DISTANCE, focus, 1.0, 1.0) / 40.0;
    let mut builder = seen(DVec3::ZERO, DVec3::NEG_Z, 2.0 * tan.atan());
    let white = builder.material(shadeless(1.0));
    let plane = half_plane(Vec3::NEG_Z * DISTANCE as f32, [Vec3::X, Vec3::Y], DVec2::X, 0.0);
    builder.mesh("half-plane", plane, DAffine3::IDENTITY, white);
    let scene = builder.build().unwrap();
    let camera = with_lens(&scene, Aperture::Disk, RADIUS, focus);
    (scene, camera)
}

/// Exact value of pixel `i`: at its centre, or, in paired mode, where the pixel is sampled as well, its mean.
fn beside_the_lens(tracer: Tracer, i: usize) -> f64 {
    // The radius of the blur is 20 pixels.
    let at = |x: f64| disk_beside_line((32.0 - x) / 20.0);
    let x = i as f64;
    if tracer == Tracer::Paired { quadrature::line(at, x, x + 1.0, 1e-7) } else { at(x + 0.5) }
}

#[test]
fn edge_beside_a_round_lens() {
    for focus in [2.0, 7.0, f64::INFINITY] {
        let (scene, camera) = blurred_edge(focus);
        for tracer in TRACERS {
            for pattern in UNBIASED {
                let settings = one_pixel(tracer, pattern, &[(Effect::Lens, [4, 4])], 16);
                let row = replicas(&scene, &camera, &Settings { size: (64, 1), ..settings }, 400);
                for (i, moments) in row.iter().enumerate() {
                    let exact = beside_the_lens(tracer, i);
                    let what = format!("focus {focus}, {tracer:?} {pattern}, pixel {i}");
                    assert_mean_known_to(&what, moments, exact, 0.008);
                }
            }
        }
    }
}

/// The concentric map takes a cell, half 1/n wide on [−1, 1]², to within √(1 + (π/2)²)/n of its centre on the unit
/// disk: 1/n along the radius, and π/4·2/n around it. Only cells that near the edge can be entirely on the wrong side.
#[test]
fn edge_beside_a_grid_on_the_lens() {
    let side = 32;
    let reach = (1.0 + 0.25 * PI * PI).sqrt() / f64::from(side);
    let (scene, camera) = blurred_edge(7.0);
    for tracer in [Tracer::Nested, Tracer::Path] {
        let plans = [(Effect::Lens, [side; 2])];
        let settings = one_pixel(tracer, Pattern::Grid, &plans, side * side);
        let row = values(&scene, &camera, &Settings { size: (64, 1), ..settings }, 0);
        for (i, value) in row.iter().enumerate() {
            let s = (32.0 - (i as f64 + 0.5)) / 20.0;
            let (low, high) = (disk_beside_line(s - reach), disk_beside_line(s + reach));
            assert!(low - 1e-6 <= *value && *value <= high + 1e-6, "pixel {i}: {low} {value} {high}");
        }
    }
}

/// An image of 40×40 pixels; the patch is 3 pixels wide, its blur 20.
const SIZE: f64 = 40.0;
const PATCH: f64 = 3.0;
const BLUR: f64 = 20.0;
const PLACE: Vec2 = Vec2::new(0.31, -0.17);

fn patch(aperture: Aperture) -> (Scene, Camera) {
    let (focus, tan) = (7.0, 0.2);
    let per_pixel = 2.0 * tan * DISTANCE / SIZE;
    let mut builder = seen(DVec3::ZERO, DVec3::NEG_Z, 2.0 * f64::atan(tan));
    let white = builder.material(shadeless(1.0));
    let side = (PATCH * per_pixel) as f32;
    let corner = ((PLACE - Vec2::splat(0.5 * PATCH as f32)) * per_pixel as f32).extend(-DISTANCE as f32);
    let plane = quad(corner, Vec3::X * side, Vec3::Y * side);
    builder.mesh("patch", plane, DAffine3::IDENTITY, white);
    let scene = builder.build().unwrap();
    let aperture_diameter = BLUR / blur_diameter(1.0, DISTANCE, focus, SIZE, tan);
    let camera = with_lens(&scene, aperture, 0.5 * aperture_diameter, focus);
    (scene, camera)
}

/// Area of the blur in pixels, and the radius of its largest inscribed circle.
fn blur_area(aperture: Aperture) -> (f64, f64) {
    let r = 0.5 * BLUR;
    match aperture {
        Aperture::Disk => (PI * r * r, r),
        Aperture::Square => (4.0 * r * r, r),
        Aperture::Blades { n, .. } => {
            (0.5 * f64::from(n) * r * r * (TAU / f64::from(n)).sin(), r * (PI / f64::from(n)).cos())
        }
    }
}

/// The centre has the light of the patch divided by the area of the lens image; the whole image has all of the light.
#[test]
fn a_patch_is_spread_and_conserved() {
    for aperture in [Aperture::Disk, Aperture::Square, Aperture::Blades { n: 6, rotation: 0.2 }] {
        let (scene, camera) = patch(aperture);
        let (area, inner) = blur_area(aperture);
        // Half diagonals of patch and pixel.
        let plateau = inner - 0.5 * (PATCH + 1.0) * std::f64::consts::SQRT_2;
        for tracer in TRACERS {
            for pattern in UNBIASED {
                let plans = [(Effect::Pixel, [2, 2]), (Effect::Lens, [4, 4])];
                let settings = Settings { size: (40, 40), ..one_pixel(tracer, pattern, &plans, 64) };
                let (mut whole, mut middle) = (Moments::default(), Moments::default());
                for seed in 0..10 {
                    let values = values(&scene, &camera, &settings, seed);
                    whole.add(values.iter().sum());
                    let inside = values.iter().enumerate().filter(|(i, _)| {
                        let (x, y) = ((i % 40) as f64 - 19.5, 19.5 - (i / 40) as f64);
                        (DVec2::new(x, y) - PLACE.as_dvec2()).length() <= plateau
                    });
                    middle.add(inside.map(|(_, v)| *v).collect::<Moments>().mean);
                }
                let what = format!("{aperture}, {tracer:?} {pattern}");
                let energy = PATCH * PATCH;
                assert_mean_known_to(&format!("{what}, whole"), &whole, energy, 0.025 * energy);
                assert_mean_known_to(
                    &format!("{what}, middle"),
                    &middle,
                    energy / area,
                    0.03 * energy / area,
                );
            }
        }
    }
}

/// Seen from any point of the lens, the patch covers the same number of film points, 12×12: a grid loses no light.
#[test]
fn a_grid_conserves_the_patch_exactly() {
    for aperture in [Aperture::Disk, Aperture::Square, Aperture::Blades { n: 6, rotation: 0.2 }] {
        let (scene, camera) = patch(aperture);
        let plans = [(Effect::Pixel, [4, 4]), (Effect::Lens, [5, 5])];
        let settings = one_pixel(Tracer::Nested, Pattern::Grid, &plans, 1);
        let values = values(&scene, &camera, &Settings { size: (40, 40), ..settings }, 0);
        let sum: f64 = values.iter().sum();
        assert!((sum / (PATCH * PATCH) - 1.0).abs() < 1e-5, "{aperture}: {sum}");
    }
}
