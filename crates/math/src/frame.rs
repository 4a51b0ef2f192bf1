//! Orthonormal frames.

use crate::lanes::{Framex, LEAST_SINE_SQUARED};
use glam::Vec3;

/// An orthonormal basis. It is right-handed unless [`Frame::from_z_tangent`] mirrors it.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// First tangent.
    pub x: Vec3,
    /// Second tangent.
    pub y: Vec3,
    /// Normal.
    pub z: Vec3,
}

impl Frame {
    /// Builds an arbitrary frame about unit `z`. No direction is singular, including z = (0, 0, −1) [Duff et al. 2017].
    pub fn from_z(z: Vec3) -> Self {
        let frame = Framex::<f32>::from_z(z.into());
        Self { x: frame.x.into(), y: frame.y.into(), z }
    }

    /// Builds the frame whose x is `tangent` made orthogonal to unit `z`; `sign` < 0 mirrors y. Falls back to
    /// [`Frame::from_z`] when the tangent is degenerate, parallel to z, or not finite.
    pub fn from_z_tangent(z: Vec3, tangent: Vec3, sign: f32) -> Self {
        let x = tangent - z * tangent.dot(z);
        let length2 = x.length_squared();
        if !(length2 > LEAST_SINE_SQUARED * tangent.length_squared() && length2.is_finite()) {
            return Self::from_z(z);
        }
        let frame = Framex::<f32>::from_z_tangent(z.into(), tangent.into(), sign);
        Self { x: frame.x.into(), y: frame.y.into(), z }
    }

    /// Returns the components of `v` along x, y and z.
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// Returns the vector with local components `v`.
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

impl From<Frame> for Framex<f32> {
    #[inline(always)]
    fn from(frame: Frame) -> Self {
        Self { x: frame.x.into(), y: frame.y.into(), z: frame.z.into() }
    }
}

impl From<Framex<f32>> for Frame {
    #[inline(always)]
    fn from(frame: Framex<f32>) -> Self {
        Self { x: frame.x.into(), y: frame.y.into(), z: frame.z.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_everywhere() {
        for i in 0..1_000_000u32 {
            let t = i as f32 * 0.618_034;
            let z = 1.0 - 2.0 * (i as f32 + 0.5) / 1e6;
            let r = (1.0 - z * z).sqrt();
            let f = Frame::from_z(Vec3::new(r * libm::cosf(t), r * libm::sinf(t), z).normalize());
            for (a, b, dot) in
                [(f.x, f.y, 0.0), (f.y, f.z, 0.0), (f.z, f.x, 0.0), (f.x, f.x, 1.0), (f.y, f.y, 1.0)]
            {
                assert!((a.dot(b) - dot).abs() < 1e-5);
            }
        }
        let f = Frame::from_z(-Vec3::Z);
        assert!((f.x.cross(f.y) - f.z).length() < 1e-6);
    }

    #[test]
    fn bad_tangents_fall_back() {
        for t in [Vec3::ZERO, Vec3::Z, Vec3::NAN, Vec3::INFINITY, Vec3::Z * 1e30] {
            let f = Frame::from_z_tangent(Vec3::Z, t, 1.0);
            assert!((f.x.length() - 1.0).abs() < 1e-5 && f.x.dot(f.z).abs() < 1e-5);
        }
    }
}
