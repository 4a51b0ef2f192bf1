//! What the tree is made of in memory: nodes of eight boxes and blocks of eight triangles, by coordinate, so that one
//! instruction takes a row of eight.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Child reference: set for a leaf block, clear for a node. The rest is the first of its lines.
pub(super) const LEAF: u32 = 1 << 31;

/// What the memory of a tree is counted in: a cache line. Nodes and blocks lie side by side, near their parents.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Line([u32; 16]);

/// Eight boxes and where they lead.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `bounds[2·axis]` are minima, `bounds[2·axis + 1]` maxima.
    pub bounds: [[f32; 8]; 6],
    pub child: [u32; 8],
    unused: [u32; 8],
}

impl Node {
    pub const LINES: usize = size_of::<Self>() / size_of::<Line>();

    /// No children: boxes that no ray enters.
    pub const NONE: Self = {
        let (low, high) = ([f32::INFINITY; 8], [f32::NEG_INFINITY; 8]);
        Self { bounds: [low, high, low, high, low, high], child: [0; 8], unused: [0; 8] }
    };

    /// The node in the lines from `at`.
    #[inline(always)]
    pub fn read(lines: &[Line], at: u32) -> &Self {
        bytemuck::cast_ref(part::<{ Self::LINES }>(lines, at))
    }

    /// As a piece of the tree's memory.
    pub fn lines(&self) -> &[Line; Self::LINES] {
        bytemuck::cast_ref(self)
    }

    pub fn set(&mut self, slot: usize, min: Vec3, max: Vec3, child: u32) {
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

    /// The block in the lines from `at`.
    #[inline(always)]
    pub fn read(lines: &[Line], at: u32) -> &Self {
        bytemuck::cast_ref(part::<{ Self::LINES }>(lines, at))
    }

    /// As a piece of the tree's memory.
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

/// The `N` lines from `at`.
#[inline(always)]
pub(super) fn part<const N: usize>(lines: &[Line], at: u32) -> &[Line; N] {
    let at = at as usize;
    lines[at..at + N].first_chunk().unwrap_or_else(|| unreachable!())
}
