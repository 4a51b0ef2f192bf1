//! Exact spheres and disks.
use glam::Vec3;
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    pub centre: Vec3,
    pub radius: f32,
}
#[derive(Clone, Copy, Debug)]
pub struct Disk {
    pub centre: Vec3,
    pub normal: Vec3,
    pub radius: f32,
}
