//! Orthonormal frames.

use super::real::Real;
use super::vec3::Vec3x;

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
