//! Helper functions for glam vectors.

use crate::lanes::{Double, Real};
use crate::offset::next_up;
use glam::{DVec3, Vec3};

/// Returns `v` normalized, or `other` when `v` is zero or not finite. `v` is scaled first, so that nothing underflows
/// or overflows.
#[must_use]
pub fn unit_or(v: DVec3, other: DVec3) -> DVec3 {
    let largest = v.abs().max_element();
    if !(largest > 0.0 && v.is_finite()) {
        return other;
    }
    let scaled = v / largest;
    scaled / scaled.length()
}

/// Converts to f32, rounding up, so that an upper bound stays an upper bound.
#[must_use]
pub fn round_up(v: DVec3) -> Vec3 {
    Vec3::new(up(v.x), up(v.y), up(v.z))
}

/// Rounds up to f32, per lane: see [`round_up`].
#[inline(always)]
pub fn up<D: Double>(x: D) -> D::Real {
    let nearest = x.to_real();
    let is_below = D::from_real(nearest).lt(x);
    D::Real::select(is_below, next_up(nearest), nearest)
}
