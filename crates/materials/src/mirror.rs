//! Mirror with square blur: averages over a square of side `blur` in the plane at distance one along the mirror
//! direction.
//!
//! R_i = normalise(R + (½−r₁) l u + (½−r₂) l v), u = normalise(n × R), v = R × u; n ∥ R uses the tangent frame.
//! Directions below the surface carry no light. The density about R is that of a plane area seen at the angle θ: 1/(l²
//! cos³θ).

use glam::{Vec2, Vec3};

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
pub struct SquareBlur {
    r: Vec3,
    u: Vec3,
    v: Vec3,
    blur: f32,
}

impl SquareBlur {
    /// Builds the lobe for `wo` above the surface.
    pub fn new(wo: Vec3, blur: f32) -> Self {
        let r = Vec3::new(-wo.x, -wo.y, wo.z);
        let u = Vec3::new(-r.y, r.x, 0.0).try_normalize().unwrap_or(Vec3::X);
        Self { r, u, v: r.cross(u), blur }
    }

    /// Samples a direction in the square; `None` if it lies below the surface.
    pub fn sample(&self, u: Vec2) -> Option<Vec3> {
        let p = (Vec2::splat(0.5) - u) * self.blur;
        let wi = (self.r + self.u * p.x + self.v * p.y).normalize();
        (wi.z > 0.0).then_some(wi)
    }

    /// Density 1/(l² cos³θ) inside the square and above the surface, else 0.
    pub fn pdf(&self, wi: Vec3) -> f32 {
        let c = wi.dot(self.r);
        let half = 0.5 * self.blur * c + SLACK * (1.0 + self.blur);
        if wi.z <= 0.0 || c <= 0.0 || wi.dot(self.u).abs() > half || wi.dot(self.v).abs() > half {
            return 0.0;
        }
        1.0 / (self.blur * self.blur * c * c * c)
    }
}
