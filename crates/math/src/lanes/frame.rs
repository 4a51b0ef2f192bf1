//! Orthonormal frames.

use super::real::Real;
use super::vec3::Vec3x;
use glam::Vec3;

/// Tangents closer to the normal than this have no direction: the square of the sine of their angle.
pub(crate) const LEAST_SINE_SQUARED: f32 = 1e-12;

/// One orthonormal, right-handed basis per lane; [`Frame`](crate::Frame) holds a single one.
#[derive(Clone, Copy, Debug)]
pub struct Framex<R> {
    /// First tangent.
    pub x: Vec3x<R>,
    /// Second tangent.
    pub y: Vec3x<R>,
    /// Normal.
    pub z: Vec3x<R>,
}

impl<R: Real> Framex<R> {
    /// Builds an arbitrary frame about unit `z`. No direction is singular, including z = (0, 0, −1) [Duff et al. 2017].
    #[inline(always)]
    pub fn from_z(z: Vec3x<R>) -> Self {
        let one = R::splat(1.0);
        let sign = one.copysign(z.z);
        let a = -one / (sign + z.z);
        let b = z.x * z.y * a;
        let x = Vec3x::new(one + sign * z.x * z.x * a, sign * b, -sign * z.x);
        let y = Vec3x::new(b, sign + z.y * z.y * a, -z.y);
        Self { x, y, z }
    }

    /// Builds the frame whose x is `tangent` made orthogonal to unit `z`, and whose y is mirrored where `sign` is
    /// negative, as [`Frame::from_z_tangent`](crate::Frame::from_z_tangent) does.
    #[inline(always)]
    pub fn from_z_tangent(z: Vec3x<R>, tangent: Vec3x<R>, sign: R) -> Self {
        let (one, zero) = (R::splat(1.0), R::splat(0.0));
        let x = tangent - z * tangent.dot(z);
        let square = x.length_squared();
        let is_usable =
            square.gt(R::splat(LEAST_SINE_SQUARED) * tangent.length_squared()) & square.is_finite();
        // Orthogonalised twice because the first subtraction cancels when the tangent is nearly parallel to z.
        let x = x / square.sqrt();
        let x = x - z * x.dot(z);
        let inverse = one / x.length();
        let x = Vec3x::select(inverse.is_finite() & inverse.gt(zero), x * inverse, Vec3x::splat(Vec3::ZERO));
        let (any, y) = (Self::from_z(z), z.cross(x));
        let y = Vec3x::select(sign.lt(zero), -y, y);
        let (x, y) = (Vec3x::select(is_usable, x, any.x), Vec3x::select(is_usable, y, any.y));
        Self { x, y, z }
    }

    /// Returns `yes` in the lanes of `mask` and `no` in the others.
    #[inline(always)]
    pub fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            x: Vec3x::select(mask, yes.x, no.x),
            y: Vec3x::select(mask, yes.y, no.y),
            z: Vec3x::select(mask, yes.z, no.z),
        }
    }

    /// Returns the components of `v` along x, y and z.
    #[inline(always)]
    pub fn to_local(&self, v: Vec3x<R>) -> Vec3x<R> {
        Vec3x::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// Returns the vector with local components `v`.
    #[inline(always)]
    pub fn to_world(&self, v: Vec3x<R>) -> Vec3x<R> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}
