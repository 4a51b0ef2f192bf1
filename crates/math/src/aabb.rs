//! Axis-aligned bounding boxes in f64.

use glam::DVec3;

/// An axis-aligned box; empty when `lo > hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least coordinate per axis.
    pub lo: DVec3,
    /// Greatest coordinate per axis.
    pub hi: DVec3,
}

impl Aabb {
    /// The box that holds nothing; its union with another box is that box.
    pub const EMPTY: Self = Self { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY };

    /// The box from corner `lo` to corner `hi`.
    #[must_use]
    pub fn new(lo: DVec3, hi: DVec3) -> Self {
        Self { lo, hi }
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Grown by `by` on all sides.
    #[must_use]
    pub fn padded(self, by: f64) -> Self {
        Self { lo: self.lo - DVec3::splat(by), hi: self.hi + DVec3::splat(by) }
    }

    /// Whether the two have a point in common.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        self.lo.cmple(other.hi).all() && other.lo.cmple(self.hi).all()
    }

    /// Distance of the farthest corner from the origin.
    #[must_use]
    pub fn reach(self) -> f64 {
        self.largest().length()
    }

    /// Largest |coordinate| per axis.
    #[must_use]
    pub fn largest(self) -> DVec3 {
        self.lo.abs().max(self.hi.abs())
    }

    /// Whether no coordinate is infinite or NaN; false of the empty box.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    /// Half of the surface area.
    #[must_use]
    pub fn half_area(self) -> f64 {
        let e = self.hi - self.lo;
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// Coordinate of the centre along one axis.
    #[must_use]
    pub fn centroid(self, axis: usize) -> f64 {
        0.5 * self.lo[axis] + 0.5 * self.hi[axis]
    }
}
