//! Closed forms and intersections in f64, independent of the crate under test.
#![allow(dead_code)]
use dapple_lights::{Area, AreaShape, Light};
use dapple_testkit::{Rng, z_test};
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::PI;

pub fn area(shape: AreaShape, two_sided: bool) -> Light {
    Light::Area(Area { shape, radiance: Vec3::ONE, two_sided })
}

/// A square of half side a with its centre at (x, 0, h), facing down.
pub fn square(a: f32, x: f32, h: f32) -> AreaShape {
    AreaShape::Quad { corner: Vec3::new(x - a, -a, h), e1: Vec3::Y * 2.0 * a, e2: Vec3::X * 2.0 * a }
}

/// Corner form factor: parallel rectangle with a corner over the receiver, X = a/h, Y = b/h.
pub fn corner(x: f64, y: f64) -> f64 {
    let (sx, sy) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / sx * (y / sx).atan() + y / sy * (x / sy).atan()) / (2.0 * PI)
}

/// E/πL under the rectangle [x0, x1] × [y0, y1] at height h.
pub fn rectangle(x: [f64; 2], y: [f64; 2], h: f64) -> f64 {
    let c = |x: f64, y: f64| corner(x / h, y / h);
    c(x[1], y[1]) - c(x[0], y[1]) - c(x[1], y[0]) + c(x[0], y[0])
}

/// Lambert's polygon: irradiance at the origin for unit radiance, clipped to the half space of `n`.
pub fn polygon(corners: &[DVec3], n: DVec3) -> f64 {
    let mut clipped = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (da, db) = (a.dot(n), b.dot(n));
        if da >= 0.0 {
            clipped.push(a);
        }
        if da * db < 0.0 {
            clipped.push(a + (b - a) * (da / (da - db)));
        }
    }
    let mut sum = 0.0;
    for (i, &a) in clipped.iter().enumerate() {
        let cross = a.cross(clipped[(i + 1) % clipped.len()]);
        let length = cross.length();
        if length > 0.0 {
            sum += length.atan2(a.dot(clipped[(i + 1) % clipped.len()])) * cross.dot(n) / length;
        }
    }
    0.5 * sum.abs()
}

/// E/πL under a disk parallel to the receiver, radius r, height h, at lateral distance d.
pub fn disk(r: f64, h: f64, d: f64) -> f64 {
    let (h2, d2, r2) = (h * h, d * d, r * r);
    let s = h2 + d2 + r2;
    // (s − 2r²)² − ... in the form that does not cancel for small disks: 1 − (s−2r²)/√(s²−4r²d²).
    let root = (s * s - 4.0 * r2 * d2).sqrt();
    let difference = (4.0 * r2 * s - 4.0 * r2 * r2 - 4.0 * r2 * d2) / (root + s - 2.0 * r2);
    0.5 * difference / root
}

/// E/L from a sphere of radius 1 with its centre at distance q ≥ 1, at angle θ to the normal.
pub fn sphere(q: f64, cos: f64) -> f64 {
    if q * cos >= 1.0 {
        return PI * cos / (q * q);
    }
    if q * cos <= -1.0 {
        return 0.0;
    }
    let sin = (1.0 - cos * cos).sqrt();
    let x = (q * q - 1.0).max(0.0).sqrt();
    let y = (-x * cos / sin).clamp(-1.0, 1.0);
    let s = sin * (1.0 - y * y).max(0.0).sqrt();
    (cos * y.acos() - x * s) / (q * q) + s.atan2(x)
}

/// Distance along the unit direction `d` from `p` to the shape, and the normal there; for spheres the nearest hit in
/// front.
pub fn hit(shape: &AreaShape, p: Vec3, d: Vec3) -> Option<(f64, DVec3)> {
    let (p, d) = (p.as_dvec3(), d.as_dvec3());
    match *shape {
        AreaShape::Triangle([a, b, c]) => {
            let a = a.as_dvec3();
            parallelogram(p, d, a, b.as_dvec3() - a, c.as_dvec3() - a, true)
        }
        AreaShape::Quad { corner, e1, e2 } => {
            parallelogram(p, d, corner.as_dvec3(), e1.as_dvec3(), e2.as_dvec3(), false)
        }
        AreaShape::Sphere { centre, radius } => {
            let (f, r) = (p - centre.as_dvec3(), radius as f64);
            let b = -f.dot(d);
            let rest = r * r - (f + d * b).length_squared();
            let root = (rest >= 0.0).then(|| rest.sqrt())?;
            let t = [b - root, b + root].into_iter().find(|t| *t > 0.0)?;
            Some((t, ((f + d * t) / r).normalize()))
        }
        AreaShape::Disk { centre, normal, radius } => {
            let (c, n) = (centre.as_dvec3(), normal.as_dvec3());
            let t = (c - p).dot(n) / d.dot(n);
            let inside = t > 0.0 && (p + d * t - c).length() <= radius as f64;
            inside.then_some((t, n))
        }
    }
}

fn parallelogram(p: DVec3, d: DVec3, a: DVec3, e1: DVec3, e2: DVec3, triangle: bool) -> Option<(f64, DVec3)> {
    let n = e1.cross(e2);
    let t = (a - p).dot(n) / d.dot(n);
    let q = p + d * t - a;
    let (s, r) = (q.cross(e2).dot(n) / n.dot(n), e1.cross(q).dot(n) / n.dot(n));
    let inside = s >= 0.0 && r >= 0.0 && if triangle { s + r <= 1.0 } else { s <= 1.0 && r <= 1.0 };
    (t > 0.0 && inside).then_some((t, n.normalize()))
}

/// Mean and standard error of `f` over `n` independent points of the unit square.
pub fn mean(n: u32, seed: u64, mut f: impl FnMut(Vec2) -> f64) -> (f64, f64) {
    let mut rng = Rng::new(seed);
    let (mut sum, mut sum2) = (0.0, 0.0);
    let mut shift = None;
    for _ in 0..n {
        let x = f(rng.vec2());
        let x = x - *shift.get_or_insert(x);
        sum += x;
        sum2 += x * x;
    }
    let n = n as f64;
    let m = sum / n;
    (m + shift.unwrap_or(0.0), ((sum2 / n - m * m).max(0.0) / (n - 1.0)).sqrt())
}

/// Irradiance at `p` by sampling `light`.
pub fn irradiance(light: &Light, p: Vec3, n: Vec3, count: u32) -> (f64, f64) {
    mean(count, 7, |u| {
        light.sample(p, u, 0.0).map_or(0.0, |s| (s.radiance.x * s.wi.dot(n).max(0.0)) as f64 / s.pdf as f64)
    })
}

/// Asserts agreement within 4 standard errors, or within the relative error `rounding` of f32 directions and densities.
#[track_caller]
pub fn agree(what: &str, (mean, se): (f64, f64), exact: f64, rounding: f64) {
    let z = z_test::exact(mean, se, exact).z.abs();
    let off = (mean - exact).abs() / exact.abs().max(f64::MIN_POSITIVE);
    assert!(
        z <= 4.0 || off <= rounding,
        "{what}: {mean} ± {se}, exact {exact}, z = {z:.1}, off by {off:.1e}"
    );
    assert!(se <= 0.01 * exact.abs() + 1e-300, "{what}: standard error {se} tests nothing at {exact}");
}
