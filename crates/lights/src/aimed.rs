//! Samples of the shapes of area lights, and the visible side of flat ones.
use crate::LightPoint;
use glam::Vec3;

/// Solid angle in sr below which triangles and quads are sampled by area. `sample` and `pdf` use the same criterion.
pub(crate) const SMALL: f64 = 1e-3;

/// A sample of a shape, independent of its emission.
pub(crate) struct Aimed {
    pub wi: Vec3,
    pub distance: f32,
    /// Density per solid angle.
    pub pdf: f32,
    pub point: LightPoint,
}

/// Visibility of a flat light from the receiver by the sign of `facing`, which is positive in front: |facing| if the
/// light emits towards the receiver; None behind a one-sided light and in the plane.
#[inline]
pub(crate) fn visible(facing: f64, two_sided: bool) -> Option<f64> {
    let facing = if two_sided { facing.abs() } else { facing };
    (facing > 0.0).then_some(facing)
}
