//! The wide tree over triangles: 8 children per node, 8 triangles per leaf block, watertight, the same bits from every
//! kernel.
//!
//! `sweep` builds a binary tree from the top down, or for large meshes `obvhs` one from the bottom up (PLOC [Benthin et
//! al. 2024] with reinsertion [Meister & Bittner 2018]); `collapse` makes it 8 wide by the dynamic programme of [Ylitie, Karras, Laine 2017]; `traverse` walks it with one of three
//! instruction sets. The tree works in units of its own, a power of two times the caller's, in which the largest
//! coordinate lies in [1, 2); so neither the scale of the scene nor the length of a direction changes what is hit.

mod build;
mod collapse;
mod hit_filter;
mod kernel;
mod lanes;
mod memory;
mod node;
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
