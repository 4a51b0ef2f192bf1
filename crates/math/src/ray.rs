//! What is a ray? Points `o + t·d` with `0 < t < t_max`; `d` need not be unit, `t` counts in lengths of `d`.
//!
//! Both ends are open: the origin itself and the point at `t_max` are never hit. Together with
//! [`offset_origin`](crate::offset::offset_origin) that makes an epsilon unnecessary.
use glam::Vec3;

/// Points `o + t·d` for 0 < t < t_max. `d` need not be unit; t counts in lengths of `d`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin, render-space units.
    pub o: Vec3,
    /// Direction, any finite length but zero.
    pub d: Vec3,
    /// Exclusive end, in lengths of `d`.
    pub t_max: f32,
}

impl Ray {
    /// A ray without end.
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Self { o, d, t_max: f32::INFINITY }
    }

    /// The same line, ending (exclusively) at `t_max`.
    pub fn until(self, t_max: f32) -> Self {
        Self { t_max, ..self }
    }

    /// `o + t·d`, rounded. Good for a look, not for shading: positions come from
    /// the surface that was hit, which knows its error.
    pub fn at(&self, t: f32) -> Vec3 {
        self.o + self.d * t
    }
}
