//! Solid angle of triangles, and sampling that is uniform in it.
//!
//! All values follow from the triple product of the first corner with the two *edges*, which keeps its precision at
//! every size. Sums of angles and normalised corners, which lose precision, are not used (see [`triangle`]). The
//! computation is in f64, because the receiver may lie in the plane of the triangle or on its edge.
use glam::{DVec2, DVec3, Vec3};
use libm::{atan2, cos, sin};

/// Solid angle in sr of the triangle `corners` seen from `p`; 0 in its plane. Positive from both sides.
///
/// tan(Ω/2) = |A·((B−A)×(C−A))| / (|A||B||C| + (A·B)|C| + (B·C)|A| + (A·C)|B|) with A, B, C from `p` to the corners
/// [Van Oosterom and Strackee 1983].
pub fn triangle(p: Vec3, corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let p = p.as_dvec3();
    let facing = facing(a - p, b - a, c - a);
    Wedge::new(facing, Arm::new(a - p), Arm::new(b - p), Arm::new(c - p)).omega
}

/// −a·(e1×e2): its absolute value is 2·area·(distance to the plane); positive if the receiver sees the front
/// (counter-clockwise).
#[inline]
pub(crate) fn facing(a: DVec3, e1: DVec3, e2: DVec3) -> f64 {
    -a.dot(e1.cross(e2))
}

/// Vector from the receiver to one corner, with its length.
#[derive(Clone, Copy)]
pub(crate) struct Arm {
    v: DVec3,
    length: f64,
}
impl Arm {
    #[inline]
    pub fn new(v: DVec3) -> Self {
        Self { v, length: v.length() }
    }
}

/// A triangle relative to the receiver, with the values needed for sampling.
#[derive(Clone, Copy)]
pub(crate) struct Wedge {
    /// Solid angle, sr.
    pub omega: f64,
    facing: f64,
    apex: Arm,
    start: Arm,
    end: Arm,
}
impl Wedge {
    /// `facing` belongs to the triangle (apex, start, end); its sign does not matter.
    #[inline]
    pub fn new(facing: f64, apex: Arm, start: Arm, end: Arm) -> Self {
        let (a, b, c) = (apex, start, end);
        let denominator = a.length * b.length * c.length
            + a.v.dot(b.v) * c.length
            + b.v.dot(c.v) * a.length
            + a.v.dot(c.v) * b.length;
        let facing = facing.abs();
        let omega = if facing > 0.0 { 2.0 * half_angle(facing, denominator) } else { 0.0 };
        Self { omega, facing, apex, start, end }
    }

    /// Unit direction, uniform in solid angle over the triangle for `u` in \[0,1)². u.x rotates the far side of the
    /// sampled part about the apex from `start` to `end`; u.y moves along it from the apex. [Arvo 1995], in the form
    /// without inverse trigonometric functions: with σ = u.x·Ω/2, the far corner of the part of solid angle 2σ is the
    /// mirror image of `start` about (G0·cosσ − G1·sinσ)·start + G2·sinσ·end [Peters 2021]. None if the receiver lies
    /// on an edge, to rounding.
    #[inline]
    pub fn sample(&self, u: DVec2) -> Option<DVec3> {
        let (apex, start, end) = (self.apex.unit()?, self.start.unit()?, self.end.unit()?);
        let g0 = self.facing / (self.apex.length * self.start.length * self.end.length);
        let g1 = end.dot(start + apex);
        let g2 = 1.0 + start.dot(apex);
        let sigma = 0.5 * u.x * self.omega;
        let (s, c) = (sin(sigma), cos(sigma));
        let r = start * (g0 * c - g1 * s) + end * (g2 * s);
        let r2 = r.length_squared();
        let far = r * (2.0 * start.dot(r) / r2) - start;
        // Uniform in height above the tangent plane of the apex: 1 − cos = u.y·(1 − apex·far), stable for short arcs.
        let height = 0.5 * (far - apex).length_squared();
        let w = u.y * height;
        let across = far - apex * (1.0 - height);
        let length = across.length();
        if !(length > 0.0 && r2 > 0.0) {
            return None;
        }
        Some(apex * (1.0 - w) + across * ((w * (2.0 - w)).max(0.0).sqrt() / length))
    }
}

impl Arm {
    #[inline]
    fn unit(&self) -> Option<DVec3> {
        (self.length > 0.0).then(|| self.v / self.length)
    }
}

/// atan2(n, d) for n > 0. For angles below 1e-5, which most lights subtend from most points, the series n/d is used
/// (relative error 3e-11), at a fraction of the cost.
#[inline]
fn half_angle(n: f64, d: f64) -> f64 {
    if n < 1e-5 * d { n / d } else { atan2(n, d) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn an_octant_is_half_pi_and_a_close_triangle_is_a_hemisphere() {
        let octant = triangle(Vec3::ZERO, [Vec3::X, Vec3::Y, Vec3::Z]);
        assert!((octant - PI / 2.0).abs() < 1e-14);
        let around = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(-0.5, 0.8, 0.0), Vec3::new(-0.5, -0.8, 0.0)];
        let close = triangle(Vec3::new(0.0, 0.0, 1e-7), around);
        assert!((close - 2.0 * PI).abs() < 2e-6, "{close}");
        assert_eq!(triangle(Vec3::new(0.1, 0.1, 0.0), around), 0.0, "in the plane");
    }

    #[test]
    fn series_and_arctangent_meet() {
        for tan in [0.99e-5, 1.01e-5] {
            assert!((half_angle(tan, 1.0) / atan2(tan, 1.0) - 1.0).abs() < 1e-10);
        }
    }

    #[test]
    fn tiny_triangles_keep_their_solid_angle() {
        for k in 0..12 {
            let s = 10f32.powi(-k);
            let corners = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(s, 0.0, 1.0), Vec3::new(0.0, s, 1.0)];
            let small = triangle(Vec3::ZERO, corners);
            if k >= 3 {
                assert!((small / (0.5 * s as f64 * s as f64) - 1.0).abs() < 3.0 * s as f64 + 1e-12);
            }
            assert!(small > 0.0);
        }
    }
}
