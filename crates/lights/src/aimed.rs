//! Where a shape was aimed at, and which side of a flat one is seen.
use crate::LightPoint;
use glam::Vec3;

/// Solid angle in sr below which triangles and quads are sampled by area. `sample` and `pdf` ask the same question.
pub(crate) const SMALL: f64 = 1e-3;

/// Where a shape was aimed at, before anything is said about what it emits.
pub(crate) struct Aimed {
    pub wi: Vec3,
    pub distance: f32,
    /// Per solid angle.
    pub pdf: f32,
    pub point: LightPoint,
}

/// The side of a flat light that `p` sees as a factor: None behind a one-sided light and in the plane.
/// `facing` > 0 in front; gives |facing|.
#[inline]
pub(crate) fn visible(facing: f64, two_sided: bool) -> Option<f64> {
    let facing = if two_sided { facing.abs() } else { facing };
    (facing > 0.0).then_some(facing)
}
