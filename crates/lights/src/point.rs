//! Point and spot lights (KHR_lights_punctual; 1 cd is read as 1 W/sr per channel).
use glam::Vec3;
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub p: Vec3,
    pub intensity: Vec3,
    /** glTF range; infinite = none */
    pub range: f32,
}
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    pub p: Vec3,
    pub axis: Vec3,
    pub intensity: Vec3,
    pub cos_inner: f32,
    pub cos_outer: f32,
    pub range: f32,
}
