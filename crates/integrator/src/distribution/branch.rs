//! A ray of the tree that is not traced yet.

use crate::emission::MisContext;
use crate::medium::MediumStack;
use crate::places::Place;
use dapple_math::Ray;
use glam::Vec3;

/// Scattering events after which the stack no longer grows with each of them.
pub(super) const DEEP: u32 = 64;

/// A ray that leaves a vertex, and what is known of it.
pub(super) struct Branch {
    pub ray: Ray,
    pub arrival: MisContext,
    /// Where it arrives.
    pub place: Place,
    /// The bodies that it goes through.
    pub stack: MediumStack,
    /// Its share in the pixel point.
    pub beta: Vec3,
    /// What the radiance that it brings counts in the radiance that leaves the vertex.
    pub factor: Vec3,
}
