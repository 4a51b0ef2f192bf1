//! Axis-aligned bounding boxes in f64.

use glam::DVec3;

/// An axis-aligned bounding box. It is empty when `lo > hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Minimum coordinate per axis.
    pub lo: DVec3,
    /// Maximum coordinate per axis.
    pub hi: DVec3,
}

impl Aabb {
    /// The empty box. Its union with another box is that other box.
    pub const EMPTY: Self = Self { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY };

    /// Creates the box with minimum corner `lo` and maximum corner `hi`.
    #[must_use]
    pub fn new(lo: DVec3, hi: DVec3) -> Self {
        Self { lo, hi }
    }

    /// Returns the smallest box that contains both boxes.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Returns the box enlarged by `by` on all sides.
    #[must_use]
    pub fn padded(self, by: f64) -> Self {
        Self { lo: self.lo - DVec3::splat(by), hi: self.hi + DVec3::splat(by) }
    }

    /// Returns whether the two boxes have a point in common.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        self.lo.cmple(other.hi).all() && other.lo.cmple(self.hi).all()
    }

    /// Returns the distance of the farthest corner from the origin.
    #[must_use]
    pub fn reach(self) -> f64 {
        self.largest().length()
    }

    /// Returns the largest |coordinate| per axis.
    #[must_use]
    pub fn largest(self) -> DVec3 {
        self.lo.abs().max(self.hi.abs())
    }

    /// Returns whether no coordinate is infinite or NaN. It is false for the empty box.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    /// Returns half of the surface area.
    #[must_use]
    pub fn half_area(self) -> f64 {
        let e = self.hi - self.lo;
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// Returns the coordinate of the centre along one axis.
    #[must_use]
    pub fn centroid(self, axis: usize) -> f64 {
        0.5 * self.lo[axis] + 0.5 * self.hi[axis]
    }
}
