//! The place a ray hit: position with error bound, normals.

use crate::offset::gamma;
use glam::{DVec3, Vec3};

/// Where a ray hit.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Position.
    pub p: Vec3,
    /// Bound of |computed − exact| per axis.
    pub p_error: Vec3,
    /// Unit geometric normal of the front side (counter-clockwise winding; sphere: outward; disk: its normal).
    pub ng: Vec3,
    /// Unit shading normal in the hemisphere of `ng`; equals `ng` on flat geometry.
    pub ns: Vec3,
}

/// Position of barycentrics (1 − u − v, u, v), with the bound γ7·Σ|b_i·p_i| of its error [pbrt-v4 §6.8.6].
pub fn interpolate(corners: &[Vec3; 3], u: f32, v: f32) -> (Vec3, Vec3) {
    let [a, b, c] = [corners[0] * (1.0 - u - v), corners[1] * u, corners[2] * v];
    (a + b + c, (a.abs() + b.abs() + c.abs()) * gamma(7))
}

/// Unit normal of the counter-clockwise side, from f64 edges; zero for a triangle without area.
pub fn geometric_normal(corners: &[Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    cross_normal(b - a, c - a)
}

fn cross_normal(e1: DVec3, e2: DVec3) -> Vec3 {
    e1.cross(e2).normalize_or_zero().as_vec3()
}
