//! Pixel to ray.
use crate::Lens;
use dapple_geometry::Ray;
use glam::{Vec2, Vec3};
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// `tan_half` = tan(yfov/2): spans the image height.
    Perspective { tan_half: f32 },
    /// Half height of the view in scene units.
    Orthographic { half_height: f32 },
}
/// Looks along −z of its frame, +y up (glTF). Units: render space.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    pub origin: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    pub backward: Vec3,
    pub projection: Projection,
    pub lens: Option<Lens>,
}
impl Camera {
    /// `film` in pixels from the top left (x right, y down), continuous; `size` of the full picture in pixels.
    /// `pixel` and `fraction` are kept apart so that no precision is lost in large pictures. `lens_u` in [0,1)².
    pub fn ray(&self, _pixel: (u32, u32), _fraction: Vec2, _size: (u32, u32), _lens_u: Vec2) -> Ray {
        todo!()
    }
}
