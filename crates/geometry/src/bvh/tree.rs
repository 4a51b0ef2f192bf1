//! The wide tree over triangles: 8 children per node, 8 triangles per leaf block, watertight, the same bits from every
//! kernel.
//!
//! `sweep` builds a binary tree from the top down, or for large meshes `obvhs` one from the bottom up (PLOC [Benthin et
//! al. 2024] with reinsertion [Meister & Bittner 2018]); `collapse` makes it 8 wide by the dynamic programme of [Ylitie, Karras, Laine 2017]; `traverse` walks it with one of three
//! instruction sets. The tree works in units of its own, a power of two times the caller's, in which the largest
//! coordinate lies in [1, 2); so neither the scale of the scene nor the length of a direction changes what is hit.

mod build;
mod collapse;
mod lanes;
mod memory;
mod node;
mod query;
mod simd;
mod stack;
mod sweep;
mod traverse;
mod triangle;

use dapple_math::Ray;
use glam::Vec3;
use memory::Memory;

/// Which instructions traversal uses. All give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// 8 lanes in one register.
    Avx2,
    /// 8 lanes in two registers; every x86-64 has it.
    Sse2,
    /// Plain arrays, any machine.
    Portable,
}

impl Kernel {
    /// Kernels this machine can run, fastest first; never empty.
    pub fn available() -> Vec<Self> {
        [Self::Avx2, Self::Sse2, Self::Portable].into_iter().filter(|&kernel| simd::runs(kernel)).collect()
    }

    fn fastest() -> Self {
        [Self::Avx2, Self::Sse2].into_iter().find(|&kernel| simd::runs(kernel)).unwrap_or(Self::Portable)
    }

    /// Name for reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx2 => "avx2",
            Self::Sse2 => "sse2",
            Self::Portable => "portable",
        }
    }
}

/// The triangle a ray hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Barycentric of corner 1.
    pub u: f32,
    /// Barycentric of corner 2.
    pub v: f32,
    /// Index in the order given to [`Tree::build`].
    pub triangle: u32,
}

/// Decides in the leaf whether a candidate counts (alpha cut-outs). `OPAQUE` compiles the question out.
pub trait Candidate {
    /// Everything counts.
    const OPAQUE: bool;
    /// Whether this hit counts.
    fn accept(&self, hit: &TriangleHit) -> bool;
}

/// Every triangle counts.
#[derive(Clone, Copy, Debug)]
pub struct Any;

impl Candidate for Any {
    const OPAQUE: bool = true;
    fn accept(&self, _: &TriangleHit) -> bool {
        true
    }
}

/// How much work goes into a tree. Hits do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// For previews and edits: about 0.4 µs per triangle.
    Fast,
    /// About 1 µs per triangle.
    Medium,
    /// About 2 µs per triangle.
    High,
}

impl Quality {
    /// The best that a mesh of this many triangles gets within about a second.
    pub fn for_count(triangles: usize) -> Self {
        match triangles {
            0..=250_000 => Self::High,
            250_001..=2_000_000 => Self::Medium,
            _ => Self::Fast,
        }
    }
}

/// A tree over triangles.
#[derive(Debug)]
pub struct Tree {
    memory: Memory,
    /// Entries the traversal stack can need.
    stack: usize,
    /// Tree units per unit of the caller, a power of two.
    scale: f32,
    /// Its inverse.
    unscale: f64,
    bounds: Option<(Vec3, Vec3)>,
    kernel: Kernel,
}

impl Tree {
    /// So many triangles fit into any tree: references reach 32 GiB, and a triangle takes 321 bytes at most (eight blocks of
    /// 320 for nine triangles, as eight or fewer share one where that is cheaper than a node, and a seventh of a node).
    pub const MOST_TRIANGLES: usize = 100_000_000;

    /// Triangles by corner. Those with a corner that is not finite or beyond 2^96, or without area (cross product in
    /// f64), are never hit, and keep their ids.
    ///
    /// # Panics
    /// If nodes and blocks take more than 32 GiB, which no [`Tree::MOST_TRIANGLES`] do.
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        Self::build_with(triangles, Quality::for_count(triangles.len()))
    }

    /// As [`Tree::build`], with the effort chosen by the caller.
    ///
    /// # Panics
    /// As [`Tree::build`].
    pub fn build_with(triangles: &[[Vec3; 3]], quality: Quality) -> Self {
        build::build(triangles, quality, Kernel::fastest())
    }

    /// Pinned to one kernel; the portable one where it cannot run.
    pub fn with_kernel(mut self, kernel: Kernel) -> Self {
        self.kernel = if simd::runs(kernel) { kernel } else { Kernel::Portable };
        self
    }

    /// The kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// The nearest triangle that counts, 0 < t < t_max; at equal t the lowest id.
    #[inline]
    pub fn closest<C: Candidate>(&self, ray: &Ray, candidate: &C) -> Option<TriangleHit> {
        simd::run::<C, false>(self, ray, candidate)
    }

    /// Whether any triangle that counts lies at 0 < t < t_max.
    #[inline]
    pub fn blocked<C: Candidate>(&self, ray: &Ray, candidate: &C) -> bool {
        simd::run::<C, true>(self, ray, candidate).is_some()
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
