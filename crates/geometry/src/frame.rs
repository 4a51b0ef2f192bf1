//! Orthonormal frames (Duff et al. 2017, sign-safe at n.z = −1).
use glam::Vec3;
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub x: Vec3,
    pub y: Vec3,
    pub z: Vec3,
}
impl Frame {
    pub fn from_z(_z: Vec3) -> Self {
        todo!()
    }
    /// x along the tangent made orthogonal to z; falls back to `from_z` when the tangent is degenerate.
    pub fn from_z_tangent(_z: Vec3, _tangent: Vec3, _sign: f32) -> Self {
        todo!()
    }
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}
