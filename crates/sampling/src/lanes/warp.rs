//! Warps from the unit square over numbers; [`crate::warp`] has those of single points.

use super::circle::{circle, eighth};
use dapple_math::lanes::{Real, Vec2x, Vec3x, sin_cos};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Samples the square [−1,1]² uniformly. pdf = 1/4 per area.
#[inline(always)]
pub fn square<R: Real>(u: Vec2x<R>) -> Vec2x<R> {
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    Vec2x::new(u.x * two - one, u.y * two - one)
}

/// Samples the unit disk uniformly, mapping concentric squares to circles [Shirley & Chiu 1997]. pdf = 1/π per area.
#[inline(always)]
pub fn disk<R: Real>(u: Vec2x<R>) -> Vec2x<R> {
    let (r, direction) = concentric(u);
    direction * r
}

/// Returns the radius (of either sign) and the direction of [`disk`].
#[inline(always)]
fn concentric<R: Real>(u: Vec2x<R>) -> (R, Vec2x<R>) {
    let p = square(u);
    let is_wide = p.x.abs().gt(p.y.abs());
    let (r, other) = (R::select(is_wide, p.x, p.y), R::select(is_wide, p.y, p.x));
    let centre = r.eq(R::splat(0.0));
    let ratio = R::select(centre, R::splat(0.0), other / R::select(centre, R::splat(1.0), r));
    // The angle from the nearer axis, which is at most π/4.
    let (sin, cos) = eighth(ratio);
    (r, Vec2x::new(R::select(is_wide, cos, sin), R::select(is_wide, sin, cos)))
}

/// Samples the hemisphere about +z with cosine weight, by projection of the disk [Pharr, Jakob & Humphreys 2023,
/// §A.5.3]. pdf = cosθ/π per solid angle.
#[inline(always)]
pub fn hemisphere_cosine<R: Real>(u: Vec2x<R>) -> Vec3x<R> {
    let (r, direction) = concentric(u);
    // Both factors of (1 − r)(1 + r) are exact, which avoids cancellation near the horizon.
    let z = ((R::splat(1.0) - r) * (R::splat(1.0) + r)).sqrt();
    Vec3x::new(r * direction.x, r * direction.y, z)
}

/// Returns the density of [`hemisphere_cosine`] per solid angle, which is 0 below the horizon and for NaN.
#[inline(always)]
pub fn hemisphere_cosine_pdf<R: Real>(cos: R) -> R {
    cos.max(R::splat(0.0)) * R::splat(FRAC_1_PI)
}

/// Samples the unit sphere uniformly. pdf = 1/4π per solid angle.
#[inline(always)]
pub fn sphere<R: Real>(u: Vec2x<R>) -> Vec3x<R> {
    cone(u, R::splat(2.0))
}

/// Samples the cone about +z with 1 − cosθ_max = `one_minus_cos` (0..2) uniformly. It is stable for cones of any size:
/// with v = u₁(1 − cosθ_max), cosθ = 1 − v and sin²θ = v(2 − v).
#[inline(always)]
pub fn cone<R: Real>(u: Vec2x<R>, one_minus_cos: R) -> Vec3x<R> {
    let v = u.x * one_minus_cos;
    let sin = (v * (R::splat(2.0) - v)).max(R::splat(0.0)).sqrt();
    let (sin_phi, cos_phi) = circle(u.y);
    Vec3x::new(sin * cos_phi, sin * sin_phi, R::splat(1.0) - v)
}

/// Returns the density of [`cone`] inside the cone: 1 / (2π(1 − cosθ_max)) per solid angle.
#[inline(always)]
pub fn cone_pdf<R: Real>(one_minus_cos: R) -> R {
    R::splat(1.0) / (R::splat(TAU) * one_minus_cos)
}

/// Samples barycentric coordinates (b1, b2) uniformly over a triangle, by folding the square without a square root
/// [Heitz 2019]. pdf = 1/area.
#[inline(always)]
pub fn triangle<R: Real>(u: Vec2x<R>) -> Vec2x<R> {
    let above = u.y.gt(u.x);
    let b = R::select(above, u.x, u.y) * R::splat(0.5);
    let rest = R::select(above, u.y, u.x) - b;
    Vec2x::new(R::select(above, b, rest), R::select(above, rest, b))
}

/// Samples the regular n-gon of circumradius 1 uniformly, with its first corner at angle `rotation` (radians).
/// pdf = 1/(½·n·sin(2π/n)) per area. Fewer than 3 blades give the disk.
#[inline(always)]
pub fn polygon<R: Real>(u: Vec2x<R>, blades: u32, rotation: f32) -> Vec2x<R> {
    if blades < 3 {
        return disk(u);
    }
    let n = blades as f32;
    let x = u.x * R::splat(n);
    let blade = x.floor().min(R::splat(n - 1.0));
    let within = (x - blade).min(R::splat(1.0 - f32::EPSILON));
    let b = triangle(Vec2x::new(within, u.y));
    corner(blade, n, rotation) * b.x + corner(blade + R::splat(1.0), n, rotation) * b.y
}

/// Returns corner i of a regular n-gon.
#[inline(always)]
fn corner<R: Real>(i: R, n: f32, rotation: f32) -> Vec2x<R> {
    let (sin, cos) = sin_cos(R::splat(rotation) + R::splat(TAU) * i / R::splat(n));
    Vec2x::new(cos, sin)
}

/// Samples the tent filter of half-width `radius` on one axis. Its density is (1 − |x|/r)/r.
#[inline(always)]
pub fn tent<R: Real>(u: R, radius: R) -> R {
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    let is_left = u.lt(R::splat(0.5));
    let side = R::select(is_left, two * u, two - two * u).max(R::splat(0.0)).sqrt();
    radius * R::select(is_left, side - one, one - side)
}

/// Returns the density of [`tent`] per length.
#[inline(always)]
pub fn tent_pdf<R: Real>(x: R, radius: R) -> R {
    ((R::splat(1.0) - x.abs() / radius) / radius).max(R::splat(0.0))
}
