//! Disks seen from close to their plane, in f64.
use crate::aimed::visible;
use glam::Vec3;
use std::f64::consts::PI;

pub(crate) struct Disk {
    pub centre: Vec3,
    pub normal: Vec3,
    /// Square of the radius.
    pub square: f64,
    pub two_sided: bool,
}

impl Disk {
    /// Direction, distance and density per solid angle of the point at `offset` from the centre.
    pub fn aim(&self, p: Vec3, offset: Vec3) -> (Vec3, f32, f32) {
        let to = self.centre.as_dvec3() - p.as_dvec3() + offset.as_dvec3();
        let distance = to.length();
        ((to / distance).as_vec3(), distance as f32, self.pdf(p, distance as f32))
    }

    /// distance²/(πR²·cosθ) with cosθ = (height over the plane)/distance.
    pub fn pdf(&self, p: Vec3, distance: f32) -> f32 {
        let height = (p.as_dvec3() - self.centre.as_dvec3()).dot(self.normal.as_dvec3());
        let d = distance as f64;
        visible(height, self.two_sided).map_or(0.0, |height| d * d * d / (PI * self.square * height)) as f32
    }
}
