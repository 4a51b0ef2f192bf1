//! Light from everywhere: a constant or a lat-long picture, importance-sampled with MIS compensation.
use dapple_imaging::Picture;
use glam::Vec3;
#[derive(Clone, Debug)]
pub struct Environment {}
impl Environment {
    pub fn constant(_radiance: Vec3) -> Self {
        todo!()
    }
    /// u = ½ + atan2(d.x, −d.z)/2π, v = acos(d.y)/π from the top row; texels are constant patches unless `filtered`.
    /// `rotation` in radians about +Y; `intensity` multiplies. Non-finite texels are an error naming the texel.
    pub fn picture(
        _picture: Picture,
        _rotation: f32,
        _intensity: f32,
        _filtered: bool,
    ) -> Result<Self, BadTexel> {
        todo!()
    }
    pub fn radiance(&self, _d: Vec3) -> Vec3 {
        todo!()
    }
    pub fn is_constant(&self) -> bool {
        todo!()
    }
    /// Whether aiming at it can help (a constant one is left to the BSDF).
    pub fn is_sampled(&self) -> bool {
        todo!()
    }
    pub fn mean(&self) -> Vec3 {
        todo!()
    }
}
#[derive(Clone, Copy, Debug)]
pub struct BadTexel {
    pub x: usize,
    pub y: usize,
    pub value: Vec3,
}
