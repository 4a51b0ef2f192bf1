//! Sampling of rectangles by a map from the unit square that is smooth and uniform in solid angle, so that grids and
//! strata keep their quality (the triangle fan in `polygon` concentrates points at its apex).
use glam::{DVec2, DVec3};
use libm::{cos, sin};

/// Cosine between the edges up to which a parallelogram is treated as a rectangle. *Approximation*: slivers of that
/// relative width along two edges are sampled too much or too little.
const SQUARE_TO: f64 = 1e-5;

pub(crate) fn is_rectangle(e1: DVec3, e2: DVec3) -> bool {
    let cos = e1.dot(e2);
    cos * cos <= SQUARE_TO * SQUARE_TO * e1.length_squared() * e2.length_squared()
}

/// Vector from the receiver to a point on the rectangle, and the coordinates of that point (along e1, e2, each in
/// \[0,1\]), for `u` in \[0,1)²: uniform in the solid angle `omega` of the rectangle with corner `p0` (relative to the
/// receiver) [Ureña, Fajardo and King 2013]. The inner angles of that method enter only by cosine and sine, and their
/// sum by `omega`, so that no inverse cosine is needed and nothing cancels close to the plane.
pub(crate) fn sample(p0: DVec3, e1: DVec3, e2: DVec3, omega: f64, u: DVec2) -> (DVec3, DVec2) {
    let lx = e1.length();
    let ex = e1 / lx;
    let (ey, ly) = (e2 - ex * ex.dot(e2)).normalize_and_length();
    let (x0, y0, z) = (p0.dot(ex), p0.dot(ey), p0.dot(ex.cross(ey)));
    let (x1, y1) = (x0 + lx, y0 + ly);
    let (h, h2) = (z.abs(), z * z);
    // z components of the unit normals of the planes through the receiver and one edge each.
    let n = |x: f64| x / (h2 + x * x).sqrt();
    let (n0, n2, n3) = (-n(y0), n(y1), -n(x0));
    // sin² of the angle between two planes: 1 − n²m² with 1 − n² = h²/(h² + x²).
    let m = |x: f64| h2 / (h2 + x * x);
    let sin_between = |a: f64, b: f64| (a + b - a * b).sqrt();
    let (c2, s2) = (-n2 * n3, sin_between(m(y1), m(x0)));
    let (c3, s3) = (-n3 * n0, sin_between(m(x0), m(y0)));
    // k = 2π − g2 − g3, a = k + u.x·omega.
    let (ck, sk) = (c2 * c3 - s2 * s3, -(s2 * c3 + c2 * s3));
    let (cu, su) = (cos(u.x * omega), sin(u.x * omega));
    let (ca, sa) = (ck * cu - sk * su, sk * cu + ck * su);
    let f = (ca * n0 - n2) / sa;
    // xu = c·h/√(1 − c²) with c = ±1/√(f² + n0²), and 1 − n0² = h²/(h² + y0²) in the form that does not cancel.
    let rest = f * f - m(y0);
    let x = if rest > 0.0 { h.copysign(f) / rest.sqrt() } else { f64::INFINITY.copysign(f) };
    let x = x.max(x0).min(x1);
    let d2 = x * x + h2;
    let height = |y: f64| y / (d2 + y * y).sqrt();
    let (low, high) = (height(y0), height(y1));
    let v = low + u.y * (high - low);
    let y = v * (d2 / (1.0 - v * v).max(f64::MIN_POSITIVE)).sqrt();
    let y = y.max(y0).min(y1);
    // Not computed from the coordinates: a receiver closer than their rounding error still gets all directions.
    (ex * x + ey * y + ex.cross(ey) * z, DVec2::new((x - x0) / lx, (y - y0) / ly))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid_angle;
    use glam::Vec3;

    /// The part with u.x below a bound, and likewise u.y, subtends the same share of the solid angle.
    #[test]
    fn parts_of_the_square_fill_their_share() {
        for (x, y, z) in [(-0.5, -0.5, 1.0), (0.3, -2.0, 0.5), (-0.2, -0.7, 1e-3), (3.0, 2.0, 0.3)] {
            let (p0, e1, e2) = (DVec3::new(x, y, z), DVec3::X, DVec3::Y * 1.5);
            let omega = |s: f64, t: f64| {
                let at = |s: f64, t: f64| (p0 + e1 * s + e2 * t).as_vec3();
                let [a, b, c, d] = [at(0.0, 0.0), at(s, 0.0), at(s, t), at(0.0, t)];
                solid_angle::triangle(Vec3::ZERO, [a, b, c]) + solid_angle::triangle(Vec3::ZERO, [a, c, d])
            };
            for share in [0.1, 0.5, 0.9] {
                let s = sample(p0, e1, e2, omega(1.0, 1.0), DVec2::new(share, 0.5)).1.x;
                let part = omega(s, 1.0) / omega(1.0, 1.0);
                assert!((part - share).abs() < 2e-6, "{p0} {share}: {part}");
            }
        }
    }

    #[test]
    fn what_is_a_rectangle() {
        assert!(is_rectangle(DVec3::new(1.0, 1e-7, 0.0), DVec3::new(0.0, 3.0, 0.0)));
        assert!(!is_rectangle(DVec3::X, DVec3::new(1e-4, 1.0, 0.0)));
    }
}
