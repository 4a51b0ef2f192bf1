//! Render space: the scene recentred and scaled by a power of two so that traversal works near unit scale.
use glam::{DVec3, Vec3};
/// render = (world − centre) · scale, in f64; scale is a power of two, the centre a multiple of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    pub centre: DVec3,
    pub scale: f64,
}
impl Space {
    pub fn fit(_min: DVec3, _max: DVec3) -> Self {
        todo!()
    }
    pub fn to_render(&self, _p: DVec3) -> Vec3 {
        todo!()
    }
    pub fn to_world(&self, _p: Vec3) -> DVec3 {
        todo!()
    }
}
