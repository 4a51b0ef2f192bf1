//! The 8-wide BVH over triangles: 8 children per node and 8 triangles per leaf block, watertight, with bit-identical
//! results from all kernels.
//!
//! A binary BVH is built top-down by `sweep`, or for large meshes bottom-up by `obvhs` (PLOC [Benthin et al. 2024] with
//! reinsertion [Meister & Bittner 2018]). `collapse` converts it to 8 children per node by the dynamic programme of
//! [Ylitie, Karras, Laine 2017], and `traverse` traverses it with one of three instruction sets. `packets` takes many rays
//! at a time through a small tree. The tree uses its own
//! unit of length, a power of two times the caller's, in which the largest coordinate is in [1, 2), so that neither the
//! scale of the scene nor the length of a ray direction affects the hits.

mod build;
mod collapse;
mod hit_filter;
mod kernel;
mod lanes;
mod leaves;
mod memory;
mod node;
mod packets;
mod query;
mod simd;
mod stack;
mod sweep;
mod traverse;
mod tree;
mod triangle;

pub use build::Quality;
pub use hit_filter::{HitFilter, Opaque, TriangleHit};
pub use kernel::Kernel;
pub use tree::Tree;
