//! What the tree is made of in memory.

use glam::Vec3;

/// Child reference: nothing there.
pub(super) const EMPTY: u32 = u32::MAX;
/// Child reference: set for a leaf block, clear for a node.
pub(super) const LEAF: u32 = 1 << 31;

/// Eight boxes as planes, and where they lead. `bounds[2·axis]` are minima, `bounds[2·axis + 1]` maxima.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct Node {
    pub bounds: [[f32; 8]; 6],
    pub child: [u32; 8],
}

impl Node {
    /// No children: boxes that no ray enters.
    pub const NONE: Self = {
        let (low, high) = ([f32::INFINITY; 8], [f32::NEG_INFINITY; 8]);
        Self { bounds: [low, high, low, high, low, high], child: [EMPTY; 8] }
    };

    pub fn set(&mut self, slot: usize, min: Vec3, max: Vec3, child: u32) {
        for axis in 0..3 {
            self.bounds[2 * axis][slot] = min[axis];
            self.bounds[2 * axis + 1][slot] = max[axis];
        }
        self.child[slot] = child;
    }
}

/// Up to eight triangles by coordinate: `corner[c][axis][lane]`. Unused lanes are NaN, which no test accepts.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct Block {
    pub corner: [[[f32; 8]; 3]; 3],
    pub id: [u32; 8],
}

impl Block {
    pub fn new(ids: &[u32], triangles: &[[Vec3; 3]]) -> Self {
        let mut block = Self { corner: [[[f32::NAN; 8]; 3]; 3], id: [u32::MAX; 8] };
        for (lane, &id) in ids.iter().take(8).enumerate() {
            block.id[lane] = id;
            for (corner, p) in triangles[id as usize].iter().enumerate() {
                for axis in 0..3 {
                    block.corner[corner][axis][lane] = p[axis];
                }
            }
        }
        block
    }
}
