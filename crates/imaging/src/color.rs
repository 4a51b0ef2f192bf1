//! sRGB transfer function, luminance.
use glam::Vec3;
pub fn luminance(_rgb: Vec3) -> f32 {
    todo!()
}
pub fn srgb_to_linear(_c: f32) -> f32 {
    todo!()
}
pub fn linear_to_srgb(_c: f32) -> f32 {
    todo!()
}
