//! The memory of a tree and its access. Rays access it at random, and the TLB holds the addresses of a limited number
//! of pages: with pages of 4 KiB, of a few MB. Large trees therefore request pages of 2 MiB, which the system provides
//! if available.
//!
//! References are checked once, when the tree is built, and then followed without bounds checks, because traversal
//! waits for the address of the next node. A [`Child`] must be used only with the memory from which it was read.

use super::node::{Block, Child, Children, Line, Node};
use std::mem::offset_of;

/// Nodes and blocks, with a reference to the root.
///
/// Invariant: all references that can be reached from the root refer to nodes and blocks within the lines.
#[derive(Debug)]
pub(super) struct Memory {
    lines: Vec<Line>,
    root: Option<Child>,
}

impl Memory {
    /// The memory of a tree without triangles.
    pub const EMPTY: Self = Self { lines: Vec::new(), root: None };

    /// Copies the lines to an allocation of exactly their size, in pages of 2 MiB if it contains at least one and the
    /// system provides them.
    ///
    /// # Panics
    /// If a reference is out of range, or a node does not come after its parent.
    pub fn new(lines: Vec<Line>, root: Child) -> Self {
        check(&lines, root);
        let mut settled = Vec::with_capacity(lines.len());
        #[cfg(all(feature = "huge-pages", target_os = "linux"))]
        huge::ask(settled.spare_capacity_mut());
        settled.extend_from_slice(&lines);
        Self { lines: settled, root: Some(root) }
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&*self.lines)
    }

    #[inline(always)]
    pub fn root(&self) -> Option<Child> {
        self.root
    }

    /// Row `i` of the bounds of every node.
    #[inline(always)]
    pub fn row(&self, i: usize) -> BoundsRow<'_> {
        BoundsRow { first: self.start().wrapping_add(offset_of!(Node, bounds) + i * ROW), memory: self }
    }

    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn children(&self, node: Child) -> &Children {
        self.debug_check(node.node_offset(), size_of::<Node>());
        // SAFETY: by the invariants, there is a node at this offset, and its children are at this place in it.
        unsafe { &*self.start().add(node.node_offset() + offset_of!(Node, child)).cast() }
    }

    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn node(&self, node: Child) -> &Node {
        self.debug_check(node.node_offset(), size_of::<Node>());
        // SAFETY: by the invariants, there is a node at this offset.
        unsafe { &*self.start().add(node.node_offset()).cast() }
    }

    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn block(&self, block: Child) -> &Block {
        self.debug_check(block.block_offset(), size_of::<Block>());
        // SAFETY: by the invariants, there is a block at this offset.
        unsafe { &*self.start().add(block.block_offset()).cast() }
    }

    /// Prefetches the first four lines of a child. The offset is that of a node; for a block it is off by the marker
    /// bit.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn prefetch(&self, child: Child) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let near = self.start().wrapping_add(child.node_offset()).cast::<i8>();
        for line in 0..4 {
            // SAFETY: SSE is part of every x86-64; a prefetch does not read.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(near.wrapping_add(64 * line)) };
        }
    }

    /// Stable Rust has no prefetch for other architectures.
    #[cfg(not(target_arch = "x86_64"))]
    #[inline(always)]
    pub fn prefetch(&self, _: Child) {}

    #[inline(always)]
    fn start(&self) -> *const u8 {
        self.lines.as_ptr().cast()
    }

    #[inline(always)]
    fn debug_check(&self, offset: usize, bytes: usize) {
        debug_assert!(offset + bytes <= self.bytes(), "a reference from another tree");
    }
}

/// Size in bytes of a row of eight values.
const ROW: usize = size_of::<[f32; 8]>();

/// One row of the bounds of every node.
#[derive(Clone, Copy)]
pub(super) struct BoundsRow<'a> {
    /// The address of the row in a node at the start of the memory.
    first: *const u8,
    memory: &'a Memory,
}

impl<'a> BoundsRow<'a> {
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn of(self, node: Child) -> &'a [f32; 8] {
        self.memory.debug_check(node.node_offset(), size_of::<Node>());
        // SAFETY: by the invariants, there is a node at this offset, and `first` is the offset of a row of bounds from
        // its start.
        unsafe { &*self.first.wrapping_add(node.node_offset()).cast() }
    }
}

/// Panics if a reference leads outside of `lines`, or a node does not come after its parent.
fn check(lines: &[Line], root: Child) {
    let mut open = vec![root];
    while let Some(child) = open.pop() {
        if child.is_block() {
            part::<{ Block::LINES }>(lines, child.block_offset());
            continue;
        }
        let node: &Node = bytemuck::cast_ref(part::<{ Node::LINES }>(lines, child.node_offset()));
        let used = node.child.iter().zip(&node.bounds[0]).filter(|(_, low)| low.is_finite());
        open.extend(used.map(|(below, _)| {
            assert!(below.block_offset() > child.node_offset(), "a child comes before its parent");
            *below
        }));
    }
}

/// The `N` lines from byte `offset`.
fn part<const N: usize>(lines: &[Line], offset: usize) -> &[Line; N] {
    let at = offset / size_of::<Line>();
    lines.get(at..).and_then(|rest| rest.first_chunk()).expect("a reference leads outside of the tree")
}

#[cfg(all(feature = "huge-pages", target_os = "linux"))]
#[allow(unsafe_code)]
mod huge {
    use crate::bvh::node::Line;
    use std::mem::MaybeUninit;

    const HUGE: usize = 2 << 20;
    /// At least the size of any page in use, so that a multiple of it is the start of a page.
    const PAGE: usize = 1 << 16;

    /// Requests large pages for memory that has not been written to.
    pub fn ask(memory: &mut [MaybeUninit<Line>]) {
        let range = memory.as_mut_ptr_range();
        let (begin, end) = (range.start.addr().next_multiple_of(PAGE), range.end.addr() / PAGE * PAGE);
        if begin + HUGE <= end {
            let begin = range.start.with_addr(begin);
            // SAFETY: whole pages of memory that is ours alone; the request changes no content. A refusal has no
            // effect.
            unsafe { libc::madvise(begin.cast(), end - begin.addr(), libc::MADV_HUGEPAGE) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::node::Node;
    use glam::Vec3;

    /// A chain of nodes, each of which contains the number of the next.
    fn chain(nodes: usize) -> Vec<Line> {
        let mut lines = Vec::new();
        for i in 0..nodes {
            let mut node = Node::NONE;
            if i + 1 < nodes {
                node.set(0, Vec3::ZERO, Vec3::splat(i as f32), Child::node((i + 1) * Node::LINES));
            }
            lines.extend(node.lines());
        }
        lines
    }

    #[test]
    fn nothing_is_lost() {
        for nodes in [1, 10_000, 30_000] {
            let memory = Memory::new(chain(nodes), Child::node(0));
            let mut at = memory.root().unwrap();
            for i in 0..nodes - 1 {
                assert_eq!(memory.row(1).of(at)[0], i as f32);
                at = memory.children(at)[0];
            }
            assert_eq!(memory.row(0).of(at)[0], f32::INFINITY);
            assert_eq!(memory.bytes(), nodes * size_of::<Node>());
        }
    }

    /// A root with the single child `child`.
    fn root_of(child: Child) -> Memory {
        let mut node = Node::NONE;
        node.set(3, Vec3::ZERO, Vec3::ONE, child);
        Memory::new(node.lines().to_vec(), Child::node(0))
    }

    #[test]
    #[should_panic(expected = "a reference leads outside of the tree")]
    fn no_reference_leads_outside() {
        root_of(Child::block(4));
    }

    #[test]
    #[should_panic(expected = "a child comes before its parent")]
    fn no_reference_leads_back() {
        root_of(Child::node(0));
    }
}
