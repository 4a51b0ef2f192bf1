//! Mirror with square blur, over lanes: averages over a square of side `blur` in the plane at distance one along the
//! mirror direction.
//!
//! R_i = normalise(R + (½−r₁) l u + (½−r₂) l v), u = normalise(n × R), v = R × u; n ∥ R uses the tangent frame.
//! Directions below the surface carry no light. The density about R is that of a plane area seen at the angle θ: 1/(l²
//! cos³θ).

use super::microfacet::unit;
use dapple_math::lanes::{Mask, Real, Vec2x, Vec3x};
use glam::Vec3;

/// Blurs below this are treated as a perfect mirror: f32 directions could not distinguish the inside of the square from
/// the outside.
pub const SHARP_BLUR: f32 = 1e-4;

/// Blurs are clamped to this: nearly every direction is perpendicular to R already.
pub const WIDEST_BLUR: f32 = 1e3;

/// Rounding error of unit vectors, by which the edge of the square may be displaced. *Approximation*: widens the
/// evaluated square by 2e-7, which is 0.2 % of the smallest blur.
const SLACK: f32 = 1e-7;

/// A mirror with square blur for one `wo`.
#[derive(Clone, Copy, Debug)]
pub struct SquareBlur<R> {
    r: Vec3x<R>,
    u: Vec3x<R>,
    v: Vec3x<R>,
    blur: R,
}

impl<R: Real> SquareBlur<R> {
    /// Builds the lobe for `wo` above the surface. The blur is clamped to [`SHARP_BLUR`] and [`WIDEST_BLUR`].
    #[inline(always)]
    pub fn new(wo: Vec3x<R>, blur: R) -> Self {
        let r = Vec3x::new(-wo.x, -wo.y, wo.z);
        let (u, tilted) = unit(Vec3x::new(-r.y, r.x, R::splat(0.0)));
        let u = Vec3x::select(tilted, u, Vec3x::splat(Vec3::X));
        let blur = blur.max(R::splat(SHARP_BLUR)).min(R::splat(WIDEST_BLUR));
        Self { r, u, v: r.cross(u), blur }
    }

    /// Samples a direction in the square. It may lie below the surface, where it carries no light.
    #[inline(always)]
    pub fn sample(&self, u: Vec2x<R>) -> Vec3x<R> {
        let half = R::splat(0.5);
        let (x, y) = ((half - u.x) * self.blur, (half - u.y) * self.blur);
        (self.r + self.u * x + self.v * y).normalize()
    }

    /// Returns the density 1/(l² cos³θ) per solid angle inside the square and above the surface, else 0.
    #[inline(always)]
    pub fn pdf(&self, wi: Vec3x<R>) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let c = wi.dot(self.r);
        let front = wi.z.gt(zero) & c.gt(zero);
        if !front.any() {
            return zero;
        }
        let half = R::splat(0.5) * self.blur * c + R::splat(SLACK) * (one + self.blur);
        let inside = front & wi.dot(self.u).abs().le(half) & wi.dot(self.v).abs().le(half);
        if !inside.any() {
            return zero;
        }
        R::select(inside, one / (self.blur * self.blur * c * c * c), zero)
    }
}
