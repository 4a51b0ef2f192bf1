//! Memory layout of the tree: nodes of eight boxes and blocks of eight triangles, stored per coordinate so that one
//! instruction loads a row of eight.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A reference to a child, which is a node or a block: its position in the memory of the tree in units of eight bytes,
/// so that an address is one scaled sum. The lowest bit, which is unused in a position, marks blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct Child(u32);

impl Child {
    const BLOCK: u32 = 1;
    const UNIT: usize = 8;

    /// The node that begins at line `line`, in the first 32 GiB.
    pub fn node(line: usize) -> Self {
        let units = line * (size_of::<Line>() / Self::UNIT);
        Self(u32::try_from(units).expect("a tree takes at most 32 GiB"))
    }

    /// The block that begins at line `line`.
    pub fn block(line: usize) -> Self {
        Self(Self::node(line).0 | Self::BLOCK)
    }

    #[inline(always)]
    pub fn is_block(self) -> bool {
        self.0 & Self::BLOCK != 0
    }

    /// The offset of a node in bytes from the start of the tree's memory.
    #[inline(always)]
    pub fn node_offset(self) -> usize {
        self.0 as usize * Self::UNIT
    }

    /// The offset of a block in bytes from the start of the tree's memory.
    #[inline(always)]
    pub fn block_offset(self) -> usize {
        (self.0 & !Self::BLOCK) as usize * Self::UNIT
    }

    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub fn from_bits(bits: u32) -> Self {
        Self(bits)
    }
}

/// The children of a node.
pub(super) type Children = [Child; 8];

/// The unit of the tree's memory: a cache line. Nodes and blocks are stored contiguously, near their parents.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Line([u32; 16]);

/// Eight bounding boxes and references to the children.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `bounds[2·axis]` are minima, `bounds[2·axis + 1]` maxima.
    pub bounds: [[f32; 8]; 6],
    pub child: Children,
    unused: [u32; 8],
}

impl Node {
    pub const LINES: usize = size_of::<Self>() / size_of::<Line>();

    /// A node without children: its boxes are never entered.
    pub const NONE: Self = {
        let (low, high) = ([f32::INFINITY; 8], [f32::NEG_INFINITY; 8]);
        Self { bounds: [low, high, low, high, low, high], child: [Child(0); 8], unused: [0; 8] }
    };

    /// The node as lines of the tree's memory.
    pub fn lines(&self) -> &[Line; Self::LINES] {
        bytemuck::cast_ref(self)
    }

    pub fn set(&mut self, slot: usize, min: Vec3, max: Vec3, child: Child) {
        for axis in 0..3 {
            self.bounds[2 * axis][slot] = min[axis];
            self.bounds[2 * axis + 1][slot] = max[axis];
        }
        self.child[slot] = child;
    }
}

/// Up to eight triangles. Unused lanes are NaN, which no test accepts.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// `corner[axis][corner][lane]`
    pub corner: [[[f32; 8]; 3]; 3],
    pub id: [u32; 8],
}

impl Block {
    pub const LINES: usize = size_of::<Self>() / size_of::<Line>();

    pub const NONE: Self = Self { corner: [[[f32::NAN; 8]; 3]; 3], id: [u32::MAX; 8] };

    /// The block as lines of the tree's memory.
    pub fn lines(&self) -> &[Line; Self::LINES] {
        bytemuck::cast_ref(self)
    }

    pub fn set(&mut self, lane: usize, id: u32, triangle: &[Vec3; 3]) {
        self.id[lane] = id;
        for (corner, p) in triangle.iter().enumerate() {
            for axis in 0..3 {
                self.corner[axis][corner][lane] = p[axis];
            }
        }
    }
}
