//! Error-bounded ray origins (pbrt-v4 §6.8): no epsilon.
use glam::Vec3;
/// `p` moved along `ng` out of its own error box, to the side `d` points to, each coordinate rounded outward.
pub fn offset_origin(_p: Vec3, _p_error: Vec3, _ng: Vec3, _d: Vec3) -> Vec3 {
    todo!()
}
