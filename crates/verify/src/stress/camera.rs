//! Stress cases A22 to A24: narrow and wide fields of view, large images, and extreme lenses.

use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{pixels, quad, run, seen, shadeless, square};
use crate::tally::Tally;
use dapple_integrator::Settings;
use dapple_integrator::camera::{Aperture, Camera, Lens, Projection};
use dapple_integrator::lights::Environment;
use dapple_integrator::math::PixelRect;
use glam::{DAffine3, DVec3, Vec2, Vec3};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "A22",
        title: "fields of view of 0.001° and 179.9°",
        naive: "a unit f32 vector cannot distinguish 1000 pixels in 1.7e-5 rad",
        source: "docs/science.md, \"Fields of view\"",
        check: Check::Run(fields),
    },
    Case {
        id: "A23",
        title: "pixel 16383 keeps its jitter",
        naive: "pixel plus jitter in one f32 leaves 2¹⁰ positions within a pixel: strata are lost",
        source: "docs/science.md, \"Fields of view\"",
        check: Check::Run(jitter),
    },
    Case {
        id: "A24",
        title: "thin lens: apertures 0 to 1e3, focus 1e-3 to infinity",
        naive: "focus point minus lens point cancels if the focus is far away",
        source: "docs/science.md, \"Thin lens\"",
        check: Check::Run(lenses),
    },
];

/// A camera at the origin, looking along −z.
fn camera(projection: Projection, lens: Option<Lens>) -> Camera {
    let (right, up, backward) = (Vec3::X, Vec3::Y, Vec3::Z);
    Camera {
        origin: Vec3::ZERO,
        right,
        up,
        backward,
        projection,
        lens,
        motion: None,
        aspect: None,
        clip: None,
    }
}

/// The slope x/−z in f64.
fn slope(d: Vec3) -> f64 {
    f64::from(d.x) / -f64::from(d.z)
}

fn fields(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let tan_half = (0.001f64.to_radians() * 0.5).tan();
    let narrow = camera(Projection::Perspective { tan_half: tan_half as f32 }, None);
    let half = Vec2::splat(0.5);
    let slopes: Vec<f64> =
        (0..1000).map(|x| slope(narrow.ray((x, 500), half, (1000, 1000), half).d)).collect();
    let step = 2.0 * tan_half / 1000.0;
    let same = slopes.windows(2).filter(|w| w[0] >= w[1]).count();
    tally.none("neighbouring pixels of 0.001° with equal directions", same as u64);
    let uneven = slopes.windows(2).map(|w| ((w[1] - w[0]) / step - 1.0).abs()).fold(0.0, f64::max);
    tally.within("largest deviation of a step between pixels", uneven, 0.0, 0.01);
    let place =
        slopes.iter().zip(0..).map(|(s, x)| (s / step - (f64::from(x) - 499.5)).abs()).fold(0.0, f64::max);
    tally.within("a pixel's direction, in pixels", place, 0.0, 0.05);
    // Any orientation, as given by look_at.
    let mut builder = seen(DVec3::new(3.0, 2.0, 5.0), DVec3::new(-1.0, 0.4, 0.2), 0.001f64.to_radians());
    builder.environment(Environment::constant(Vec3::ONE));
    match builder.build() {
        Ok(scene) => turned(&mut tally, &scene.cameras[0].camera, step),
        Err(_) => tally.holds("the rotated view is built", false),
    }
    edge_in_view(&mut tally, step);
    wide(&mut tally, effort);
    tally.finish()
}

/// Checks the directions of a narrow field of view in the axes of any camera, in pixels of `step`.
fn turned(tally: &mut Tally, camera: &Camera, step: f64) {
    let half = Vec2::splat(0.5);
    let (right, backward) = (camera.right.as_dvec3(), camera.backward.as_dvec3());
    let slopes: Vec<f64> = (0..1000)
        .map(|x| camera.ray((x, 500), half, (1000, 1000), half).d.as_dvec3())
        .map(|d| d.dot(right) / -d.dot(backward))
        .collect();
    let same = slopes.windows(2).filter(|w| w[0] >= w[1]).count();
    tally.none("neighbours in a rotated frame with equal directions", same as u64);
    // The axes themselves are rounded, which rotates the image as a whole; deviations are relative to its centre.
    let middle = slopes.iter().sum::<f64>() / 1000.0;
    let off = slopes.iter().zip(0..).map(|(s, x)| ((s - middle) / step - (f64::from(x) - 499.5)).abs());
    tally.within("a pixel's direction in a rotated frame, in pixels", off.fold(0.0, f64::max), 0.0, 0.25);
}

/// Checks the image position of an edge at a known angle by the part of row 500 that a half-plane covers, at distances
/// 1 and 10 000.
fn edge_in_view(tally: &mut Tally, step: f64) {
    for distance in [1.0f64, 1e4] {
        for edge in [-321.0f64, 0.0, 77.0] {
            let x = edge * step * distance;
            let mut builder = seen(DVec3::ZERO, DVec3::NEG_Z, 0.001f64.to_radians());
            let white = builder.material(shadeless(1.0));
            let side = 2e3 * step * distance;
            let half_plane = quad(Vec3::new(0.0, -1.0, 0.0), Vec3::X, Vec3::Y * 2.0);
            let place = DAffine3::from_translation(DVec3::new(x, 0.0, -distance))
                * DAffine3::from_scale(DVec3::splat(side));
            builder.mesh("half-plane", half_plane, place, white);
            let row = PixelRect { x0: 0, y0: 500, x1: 1000, y1: 501 };
            let settings = Settings { crop: Some(row), ..square(1000, 1) };
            let Ok(scene) = builder.build() else { return tally.holds("the edge is built", false) };
            let lit = run(&scene, &settings).film.mean().pixels.iter().filter(|p| p.x > 0.0).count();
            tally.within(
                format!("pixels beyond an edge at {edge} pixels, distance {distance}"),
                lit as f64,
                500.0 - edge,
                1.0,
            );
        }
    }
}

fn wide(tally: &mut Tally, effort: Effort) {
    let mut builder = seen(DVec3::ZERO, DVec3::NEG_Z, 179.9f64.to_radians());
    builder.environment(Environment::constant(Vec3::splat(0.75)));
    let sky = pixels(builder, &square(effort.of(32, 128, 1024), 1));
    tally.within("constant sky in a field of 179.9°", sky.map_or(f64::NAN, |m| m.mean), 0.75, 0.0);
    let t = (179.9f64.to_radians() * 0.5).tan();
    let wide = camera(Projection::Perspective { tan_half: t as f32 }, None);
    // A sum of cos³θ over fine cells near the axis would not test the solid angle of the film; its corners do.
    let corner = wide.ray((0, 0), Vec2::ZERO, (64, 64), Vec2::ZERO).d.as_dvec3();
    let edge = t / (1.0 + 2.0 * t * t).sqrt();
    tally.within("the corner's direction", corner.x, -edge, 1e-6);
    let w = |x: f64, y: f64| (x * y / (1.0 + x * x + y * y).sqrt()).atan();
    tally.within("solid angle of the film", 4.0 * w(t, t), 4.0 * (t * t / (1.0 + t * t)).asin(), 1e-9);
}

fn jitter(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let wide = camera(Projection::Orthographic { half_height: 0.5 }, None);
    // The requested positions (i + ½)/n are exact up to this n.
    let n = effort.of(1 << 16, 1 << 21, 1 << 23);
    let (mut seen, mut bins) = (std::collections::HashSet::new(), [0u64; 64]);
    for i in 0..n {
        let u = (i as f32 + 0.5) / n as f32;
        let x = f64::from(wide.ray((16_383, 8192), Vec2::new(u, 0.5), (16_384, 16_384), Vec2::ZERO).o.x);
        // The image spans −½ to ½; the last pixel begins at ½ − 1/16384.
        let within = (x - 0.5) * 16_384.0 + 1.0;
        bins[((within * 64.0) as usize).min(63)] += 1;
        seen.insert(x.to_bits());
    }
    let even = n as f64 / 64.0;
    let worst = bins.iter().map(|&b| (b as f64 / even - 1.0).abs()).fold(0.0, f64::max);
    tally.within(
        "largest deviation of a 64th of the pixel",
        worst,
        0.0,
        64.0 * 2.0 / (f64::from(f32::EPSILON).recip() / 16_384.0),
    );
    // The perspective camera computes the direction in f64 before rounding it: near the axis all digits are retained.
    let perspective = camera(Projection::Perspective { tan_half: 1.0 }, None);
    let mut distinct = std::collections::HashSet::new();
    for i in 0..n {
        let u = (i as f32 + 0.5) / n as f32;
        distinct.insert(
            perspective.ray((16_383, 16_383), Vec2::new(u, 0.5), (32_768, 32_768), Vec2::ZERO).d.x.to_bits(),
        );
    }
    tally.within(
        "distinct positions within the pixel left of the axis",
        distinct.len() as f64,
        n as f64,
        0.01 * n as f64,
    );
    tally.remark(format!(
        "{} positions within pixel 16383 of an orthographic view (f32 resolves 2¹⁰ there, the pixel itself 2²⁴)",
        seen.len()
    ));
    tally.finish()
}

fn lenses(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let projection = Projection::Perspective { tan_half: 0.4 };
    let pinhole = camera(projection, None);
    let mut noise = Noise(2);
    for focus_distance in [1e-3f32, 1.0, 1e3, 1e9, f32::INFINITY] {
        for radius in [0.0f32, 1e-9, 1e-3, 1.0, 1e3] {
            let lens = Lens { aperture: Aperture::Disk, radius, focus_distance };
            let lensed = camera(projection, Some(lens));
            let (mut worst, mut bits, mut bad) = (0.0f64, 0, 0);
            for _ in 0..effort.of(200, 5_000, 100_000) {
                let (pixel, u, v) =
                    ((noise.below(100) as u32, noise.below(100) as u32), noise.point(), noise.point());
                let a = pinhole.ray(pixel, u, (100, 100), v);
                let b = lensed.ray(pixel, u, (100, 100), v);
                bad += u64::from(!(b.o.is_finite() && b.d.is_finite()));
                bits += u64::from(radius == 0.0 && (a.o != b.o || a.d != b.d));
                worst = worst.max(off_focus(&a.d, &b.o, &b.d, focus_distance, radius));
            }
            let what = format!("aperture {radius}, focus {focus_distance}");
            tally.none(format!("{what}: rays not finite"), bad);
            tally.none(format!("{what}: bits that differ from the pinhole"), bits);
            tally.within(format!("{what}: blur of the plane of focus"), worst, 0.0, 1e-5);
        }
    }
    tally.finish()
}

/// Distance between the intersections of a pinhole ray and a lens ray with the plane of focus, divided by the quantity
/// that limits it: the largest of the point's distance from the axis, the lens radius and the length of the ray.
fn off_focus(pinhole: &Vec3, o: &Vec3, d: &Vec3, focus: f32, radius: f32) -> f64 {
    let (p, o, d) = (pinhole.as_dvec3(), o.as_dvec3(), d.as_dvec3());
    if focus.is_infinite() {
        return (p - d).length();
    }
    let z = f64::from(focus);
    let sharp = p * (z / -p.z);
    let met = o + d * (z / -d.z);
    (sharp - met).length() / sharp.length().max(f64::from(radius)).max((met - o).length())
}
