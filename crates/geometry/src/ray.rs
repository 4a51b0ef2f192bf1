//! A ray.

use glam::Vec3;

/// Points `o + t·d` for 0 < t < t_max. `d` need not be unit; t counts in lengths of `d`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin.
    pub o: Vec3,
    /// Direction, any length but zero.
    pub d: Vec3,
    /// Hits at or beyond it do not count.
    pub t_max: f32,
}

impl Ray {
    /// A ray without end.
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Self { o, d, t_max: f32::INFINITY }
    }

    /// The point at `t`; for hit points use [`crate::World::surface`], which is more accurate.
    pub fn at(&self, t: f32) -> Vec3 {
        self.o + self.d * t
    }
}
