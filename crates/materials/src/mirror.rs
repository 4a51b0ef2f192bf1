//! The square blur: a mirror that averages over a square of side `blur` on the plane one unit along the mirror direction.
//!
//! R_i = normalise(R + (½−r₁) l u + (½−r₂) l v), u = normalise(n × R), v = R × u; n ∥ R takes the tangent frame. Directions
//! under the surface carry nothing. The density about R is that of a plane area seen under θ: 1/(l² cos³θ).

use glam::{Vec2, Vec3};

/// Blurs below this are a perfect mirror: f32 directions could not tell the inside of the square from the outside.
pub const SHARP_BLUR: f32 = 1e-4;

/// Blurs above this are taken as this: nearly every direction is at right angles to R already.
pub const WIDEST_BLUR: f32 = 1e3;

/// Rounding of unit vectors, on which the edge of the square may be off. *Approximation*: widens the evaluated square by
/// 2e-7, which is 0.2 % of the smallest blur.
const SLACK: f32 = 1e-7;

/// A blurred mirror seen from one `wo`.
#[derive(Clone, Copy, Debug)]
pub struct SquareBlur {
    r: Vec3,
    u: Vec3,
    v: Vec3,
    blur: f32,
}

impl SquareBlur {
    /// `wo` above the surface.
    pub fn new(wo: Vec3, blur: f32) -> Self {
        let r = Vec3::new(-wo.x, -wo.y, wo.z);
        let u = Vec3::new(-r.y, r.x, 0.0).try_normalize().unwrap_or(Vec3::X);
        Self { r, u, v: r.cross(u), blur }
    }

    /// A direction of the square; `None` when it lies under the surface.
    pub fn sample(&self, u: Vec2) -> Option<Vec3> {
        let p = (Vec2::splat(0.5) - u) * self.blur;
        let wi = (self.r + self.u * p.x + self.v * p.y).normalize();
        (wi.z > 0.0).then_some(wi)
    }

    /// 1/(l² cos³θ) inside the square and above the surface, else 0.
    pub fn pdf(&self, wi: Vec3) -> f32 {
        let c = wi.dot(self.r);
        let half = 0.5 * self.blur * c + SLACK * (1.0 + self.blur);
        if wi.z <= 0.0 || c <= 0.0 || wi.dot(self.u).abs() > half || wi.dot(self.v).abs() > half {
            return 0.0;
        }
        1.0 / (self.blur * self.blur * c * c * c)
    }
}
