//! Cosine-weighted directions over lanes.

use dapple_math::lanes::{Real, Vec2x, Vec3x, sin_cos};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_4};

/// Samples the hemisphere about +z with cosine weight, by projection of the disk [Pharr, Jakob & Humphreys 2023,
/// §A.5.3], to which concentric squares are mapped as circles [Shirley & Chiu 1997]. pdf = cosθ/π per solid angle.
#[inline(always)]
pub fn hemisphere_cosine<R: Real>(u: Vec2x<R>) -> Vec3x<R> {
    let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
    let (x, y) = (u.x * two - one, u.y * two - one);
    let along_x = x.abs().gt(y.abs());
    let (r, other) = (R::select(along_x, x, y), R::select(along_x, y, x));
    // The angle from the nearer axis, which is at most π/4.
    let ratio = R::select(r.eq(zero), zero, other / r);
    let (sin, cos) = sin_cos(ratio * R::splat(FRAC_PI_4));
    let (x, y) = (R::select(along_x, cos, sin), R::select(along_x, sin, cos));
    // Both factors of (1 − r)(1 + r) are exact, which avoids cancellation near the horizon.
    Vec3x::new(r * x, r * y, ((one - r) * (one + r)).sqrt())
}

/// Returns the density of [`hemisphere_cosine`] per solid angle, which is 0 below the horizon.
#[inline(always)]
pub fn hemisphere_cosine_pdf<R: Real>(cos: R) -> R {
    cos.max(R::splat(0.0)) * R::splat(FRAC_1_PI)
}
