//! The BVH over triangles: its nodes and blocks, and its unit of length.

use super::kernel::Kernel;
use super::leaves::Leaf;
use super::memory::Memory;
use glam::Vec3;

/// A BVH over triangles.
#[derive(Debug)]
pub struct Tree {
    pub(super) memory: Memory,
    /// The largest number of entries that the traversal stack can need.
    pub(super) stack: usize,
    /// Tree units per unit of the caller; a power of two.
    pub(super) scale: f32,
    /// The inverse of `scale`.
    pub(super) unscale: f64,
    pub(super) bounds: Option<(Vec3, Vec3)>,
    pub(super) kernel: Kernel,
    /// The number of triangles that can be hit.
    pub(super) triangles: usize,
    /// The leaves, if the tree is so small that many rays are traced in packets.
    pub(super) leaves: Vec<Leaf>,
}

impl Tree {
    /// The number of triangles that fit into any tree: references reach 32 GiB, and a triangle takes at most 321 bytes
    /// (eight blocks of 320 bytes for nine triangles, as up to eight triangles share a block where that is cheaper than
    /// a node, and a seventh of a node).
    pub const MOST_TRIANGLES: usize = 100_000_000;

    /// Selects one traversal kernel; the portable one if this machine cannot run it.
    pub fn with_kernel(mut self, kernel: Kernel) -> Self {
        self.kernel = if kernel.runs() { kernel } else { Kernel::Portable };
        self
    }

    /// The kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// The bounding box of all triangles that can be hit; None when there are none.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        self.bounds
    }

    /// Memory of nodes and leaf blocks in bytes.
    pub fn memory_bytes(&self) -> usize {
        self.memory.bytes()
    }
}
