//! Emitting triangles, quads, spheres and disks, aimed at by solid angle where it pays.
use glam::Vec3;
#[derive(Clone, Debug)]
pub struct Area {
    pub shape: AreaShape,
    /** mean radiance */
    pub radiance: Vec3,
    pub two_sided: bool,
}
/// Front side = counter-clockwise / outward / `normal`.
#[derive(Clone, Copy, Debug)]
pub enum AreaShape {
    Triangle([Vec3; 3]),
    /// Parallelogram: corner, edge, edge.
    Quad {
        corner: Vec3,
        e1: Vec3,
        e2: Vec3,
    },
    Sphere {
        centre: Vec3,
        radius: f32,
    },
    Disk {
        centre: Vec3,
        normal: Vec3,
        radius: f32,
    },
}
