//! Rays: the points `o + t·d` with `0 < t < t_max`. `d` need not be unit; `t` is in units of the length of `d`.
//!
//! The interval is open at both ends: neither the origin itself nor the point at `t_max` is ever hit. Together with
//! [`offset_origin`](crate::offset::offset_origin) this makes an epsilon unnecessary.
use glam::Vec3;

/// The points `o + t·d` with 0 < t < t_max. `d` need not be unit; t is in units of the length of `d`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin in render-space units.
    pub o: Vec3,
    /// Direction, of any finite non-zero length.
    pub d: Vec3,
    /// Exclusive end of the ray, in units of the length of `d`.
    pub t_max: f32,
}

impl Ray {
    /// Creates a ray of infinite length.
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Self { o, d, t_max: f32::INFINITY }
    }

    /// Returns the same ray with the exclusive end `t_max`.
    pub fn until(self, t_max: f32) -> Self {
        Self { t_max, ..self }
    }

    /// Returns `o + t·d`, rounded. It has no error bound: positions for shading are computed
    /// from the intersected surface, which has one.
    pub fn at(&self, t: f32) -> Vec3 {
        self.o + self.d * t
    }
}
