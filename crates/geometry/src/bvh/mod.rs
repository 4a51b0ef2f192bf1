//! The wide tree over triangles: 8 children per node, 8 triangles per leaf block, watertight, the same bits from every
//! kernel.
//!
//! `obvhs` builds a binary tree (PLOC [Benthin et al. 2024] with reinsertion [Meister & Bittner 2018]); [`collapse`]
//! makes it 8 wide by the dynamic programme of [Ylitie, Karras, Laine 2017]; [`traverse`] walks it with one of three
//! instruction sets.

mod collapse;
mod node;
mod simd;
mod traverse;
mod triangle;

use crate::Ray;
use glam::Vec3;
use node::{Block, Node};

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
        let mut kernels = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            if std::arch::is_x86_feature_detected!("avx2") {
                kernels.push(Self::Avx2);
            }
            kernels.push(Self::Sse2);
        }
        kernels.push(Self::Portable);
        kernels
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

/// A tree over triangles.
#[derive(Debug)]
pub struct Tree {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
    /// Reference of the root: a node, a block, or nothing.
    root: u32,
    /// Entries the traversal stack can need.
    stack: usize,
    bounds: Option<(Vec3, Vec3)>,
    kernel: Kernel,
}

impl Tree {
    /// Triangles by corner. Those with corners that are not finite or without area (cross product in f64) are never
    /// hit, and keep their ids.
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        let bounds = bounds(triangles);
        let (nodes, blocks, root, stack) = collapse::build(triangles);
        Self { nodes, blocks, root, stack, bounds, kernel: Kernel::available()[0] }
    }

    /// Pinned to one kernel; falls back to the portable one where it cannot run.
    pub fn with_kernel(mut self, kernel: Kernel) -> Self {
        self.kernel = if Kernel::available().contains(&kernel) { kernel } else { Kernel::Portable };
        self
    }

    /// The kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// The nearest triangle that counts, 0 < t < t_max; at equal t the lowest id.
    #[inline]
    pub fn closest<C: Candidate>(&self, ray: &Ray, candidate: &C) -> Option<TriangleHit> {
        traverse::dispatch::<C, false>(self, ray, candidate)
    }

    /// Whether any triangle that counts lies at 0 < t < t_max.
    #[inline]
    pub fn blocked<C: Candidate>(&self, ray: &Ray, candidate: &C) -> bool {
        traverse::dispatch::<C, true>(self, ray, candidate).is_some()
    }

    /// Box around all triangles that can be hit.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        self.bounds
    }

    /// Bytes of nodes and leaf blocks.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.blocks)
    }
}

/// Finite, and not without area.
fn can_be_hit(t: &[Vec3; 3]) -> bool {
    let [a, b, c] = t.map(|p| p.as_dvec3());
    t.iter().all(|p| p.is_finite()) && (b - a).cross(c - a) != glam::DVec3::ZERO
}

fn bounds(triangles: &[[Vec3; 3]]) -> Option<(Vec3, Vec3)> {
    let corners = triangles.iter().filter(|t| can_be_hit(t)).flatten();
    corners.map(|p| (*p, *p)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}
