//! A ray.
use glam::Vec3;
/// Points `o + t·d` for 0 < t < t_max. `d` need not be unit; t counts in lengths of `d`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub o: Vec3,
    pub d: Vec3,
    pub t_max: f32,
}
impl Ray {
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Self { o, d, t_max: f32::INFINITY }
    }
}
