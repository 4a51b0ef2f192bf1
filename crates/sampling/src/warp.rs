//! From the unit square to the shapes of rendering, each with its density. All total on [0,1)².
use glam::{Vec2, Vec3};
pub fn disk(_u: Vec2) -> Vec2 {
    todo!()
}
pub fn hemisphere_cosine(_u: Vec2) -> Vec3 {
    todo!()
}
pub fn hemisphere_cosine_pdf(_cos: f32) -> f32 {
    todo!()
}
pub fn sphere(_u: Vec2) -> Vec3 {
    todo!()
}
/// Uniform in the cone about +z given `one_minus_cos` = 1 − cosθ_max (stable for tiny cones).
pub fn cone(_u: Vec2, _one_minus_cos: f32) -> Vec3 {
    todo!()
}
pub fn cone_pdf(_one_minus_cos: f32) -> f32 {
    todo!()
}
/// Barycentrics (b1, b2) uniform over a triangle.
pub fn triangle(_u: Vec2) -> Vec2 {
    todo!()
}
/// Regular n-gon of circumradius 1, first corner at angle `rotation` (radians).
pub fn polygon(_u: Vec2, _blades: u32, _rotation: f32) -> Vec2 {
    todo!()
}
/// Tent filter of radius r on one axis.
pub fn tent(_u: f32, _radius: f32) -> f32 {
    todo!()
}
