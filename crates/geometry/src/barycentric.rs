//! Points of triangles by barycentric coordinates, in f64, and the bounds of their errors.

use dapple_math::lanes::Double;
use dapple_math::offset::gamma;
use glam::{DVec3, Vec3};

/// Σ bᵢxᵢ and Σ|bᵢxᵢ|, with barycentric coordinates that sum to one in f64.
pub(crate) fn weighted(x: [Vec3; 3], u: f32, v: f32) -> (DVec3, DVec3) {
    let [a, b, c] = x.map(|x| x.as_dvec3());
    let shares = shares(f64::from(u), f64::from(v));
    let sum = |a, b, c| weighted_sum([a, b, c], shares);
    let [x, y, z] = [sum(a.x, b.x, c.x), sum(a.y, b.y, c.y), sum(a.z, b.z, c.z)];
    (DVec3::new(x.0, y.0, z.0), DVec3::new(x.1, y.1, z.1))
}

/// The shares of the three corners.
#[inline(always)]
pub(crate) fn shares<D: Double>(u: D, v: D) -> [D; 3] {
    [D::splat(1.0) - u - v, u, v]
}

/// One axis of [`weighted`], per lane.
#[inline(always)]
pub(crate) fn weighted_sum<D: Double>([a, b, c]: [D; 3], [w, u, v]: [D; 3]) -> (D, D) {
    let (a, b, c) = (a * w, b * u, c * v);
    (a + b + c, a.abs() + b.abs() + c.abs())
}

/// Fraction of the largest coordinate that the error bounds include on every axis. A plane x = 0 has no error along x,
/// but the f64 part of the intersection test mixes the axes, more so for longer triangles (measured: up to 2⁻⁴² on
/// slivers of aspect ratio 1e6).
pub(crate) const MIXED: f64 = 1.0 / (1u64 << 40) as f64;

/// γₙ·size, plus a small fraction of the largest axis on all axes.
pub(crate) fn test_error(size: DVec3, n: u32) -> DVec3 {
    DVec3::from_array(test_errors([size.x, size.y, size.z], n))
}

/// [`test_error`] per lane.
#[inline(always)]
pub(crate) fn test_errors<D: Double>([x, y, z]: [D; 3], n: u32) -> [D; 3] {
    let (factor, mixed) = (D::splat(f64::from(gamma(n))), x.max(y.max(z)) * D::splat(MIXED));
    [x * factor + mixed, y * factor + mixed, z * factor + mixed]
}
