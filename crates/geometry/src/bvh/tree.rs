//! The tree itself: nodes and blocks in memory, and the units that they are in.

use super::kernel::Kernel;
use super::memory::Memory;
use glam::Vec3;

/// A tree over triangles.
#[derive(Debug)]
pub struct Tree {
    pub(super) memory: Memory,
    /// Entries the traversal stack can need.
    pub(super) stack: usize,
    /// Tree units per unit of the caller, a power of two.
    pub(super) scale: f32,
    /// Its inverse.
    pub(super) unscale: f64,
    pub(super) bounds: Option<(Vec3, Vec3)>,
    pub(super) kernel: Kernel,
}

impl Tree {
    /// So many triangles fit into any tree: references reach 32 GiB, and a triangle takes 321 bytes at most (eight blocks of
    /// 320 for nine triangles, as eight or fewer share one where that is cheaper than a node, and a seventh of a node).
    pub const MOST_TRIANGLES: usize = 100_000_000;

    /// Pinned to one kernel; the portable one where it cannot run.
    pub fn with_kernel(mut self, kernel: Kernel) -> Self {
        self.kernel = if kernel.runs() { kernel } else { Kernel::Portable };
        self
    }

    /// The kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Box around all triangles that can be hit.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        self.bounds
    }

    /// Bytes of nodes and leaf blocks.
    pub fn memory_bytes(&self) -> usize {
        self.memory.bytes()
    }
}
