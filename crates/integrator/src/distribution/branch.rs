//! A pending ray of the ray tree.

use crate::emission::MisContext;
use crate::medium::MediumStack;
use crate::places::Place;
use dapple_math::Ray;
use glam::Vec3;

/// Depth in scattering events beyond which the call stack no longer grows with each event.
pub(super) const DEEP: u32 = 64;

/// A ray that leaves a vertex, with its state.
pub(super) struct Branch {
    pub ray: Ray,
    pub arrival: MisContext,
    /// Position in the ray tree at which the ray arrives.
    pub place: Place,
    /// The bodies around the ray.
    pub stack: MediumStack,
    /// Throughput from the pixel sample to this ray.
    pub beta: Vec3,
    /// Factor of this ray's radiance in the radiance that leaves the vertex.
    pub factor: Vec3,
}
