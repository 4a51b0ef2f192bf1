//! The leaves of a small tree in a list, as packets of rays visit them.

use super::memory::Memory;
use super::node::{Block, Child};

/// A block of triangles and its box.
#[derive(Debug)]
pub(super) struct Leaf {
    /// As the bounds of a node.
    pub bounds: [f32; 6],
    pub block: Block,
    /// The corners of the triangles by index in `points`.
    pub corners: Vec<[u8; 3]>,
    /// The different corners, fewer than [`Leaf::POINTS`].
    pub points: Vec<[f32; 3]>,
}

impl Leaf {
    /// Above the number of corners of eight triangles.
    pub const POINTS: usize = 32;

    fn new(bounds: [f32; 6], block: Block) -> Self {
        let mut leaf = Self { bounds, block, corners: Vec::new(), points: Vec::new() };
        for lane in (0..8).filter(|&lane| block.id[lane] != u32::MAX) {
            let corners = [0, 1, 2].map(|corner| block.corner.map(|axis| axis[corner][lane]));
            let triangle = corners.map(|p| leaf.index(p));
            leaf.corners.push(triangle);
        }
        leaf
    }

    /// The id of a triangle.
    #[inline(always)]
    pub fn id(&self, slot: usize) -> u32 {
        self.block.id[slot % 8]
    }

    /// The index of a point, which is added if it is new.
    fn index(&mut self, p: [f32; 3]) -> u8 {
        let is_equal = |other: &[f32; 3]| other.map(f32::to_bits) == p.map(f32::to_bits);
        let known = self.points.iter().position(is_equal);
        let i = known.unwrap_or(self.points.len());
        if known.is_none() {
            self.points.push(p);
        }
        i as u8
    }
}

/// The leaves of a tree in the order of the children.
pub(super) fn leaves(memory: &Memory) -> Vec<Leaf> {
    let (low, high) = (f32::NEG_INFINITY, f32::INFINITY);
    let everywhere = [low, high, low, high, low, high];
    let mut open: Vec<([f32; 6], Child)> = memory.root().map(|root| (everywhere, root)).into_iter().collect();
    let mut leaves = Vec::new();
    while let Some((bounds, at)) = open.pop() {
        if at.is_block() {
            leaves.push(Leaf::new(bounds, *memory.block(at)));
            continue;
        }
        let node = memory.node(at);
        let used = (0..8).rev().filter(|&slot| node.bounds[0][slot].is_finite());
        open.extend(used.map(|slot| (node.bounds.map(|row| row[slot]), node.child[slot])));
    }
    leaves
}
