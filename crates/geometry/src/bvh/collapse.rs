//! Conversion of the binary BVH to the 8-wide one.
//!
//! The dynamic programme of [Ylitie, Karras, Laine 2017, §3] finds the choice of minimal surface-area cost: which
//! binary nodes become children of one wide node, and which subtrees become leaves.

use super::node::{Block, Child, Line, Node};
use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;

/// Maximum number of triangles in a leaf: one block.
const LEAF_SIZE: u32 = 8;
/// Cost of testing a block, in units of node tests.
const LEAF_COST: f32 = 0.7;
/// Subtrees smaller than this are not processed on another thread.
#[cfg(feature = "parallel")]
const PARALLEL: usize = 1 << 14;

/// The wide tree; its root is the node at line 0.
pub(super) struct Wide {
    pub lines: Vec<Line>,
    /// Number of nodes on the longest path from the root.
    pub depth: usize,
}

/// Converts `binary`, which has one triangle per leaf and at least two of them, to a wide tree.
pub(super) fn collapse(binary: &Bvh2, ids: &[u32], triangles: &[[Vec3; 3]]) -> Wide {
    let flat = preorder(binary);
    let mut plans = vec![CollapseCost::LEAF; flat.len()];
    solve(&flat, &mut plans, 12);
    emit(&flat, &plans, ids, triangles)
}

/// A binary node; its left child is the next in the list.
struct Flat {
    hull: Aabb,
    /// Distance to the right child in the list; 0 for a triangle.
    right: u32,
    /// The triangle of a leaf, else the number of triangles.
    value: u32,
}

impl Flat {
    fn count(&self) -> u32 {
        if self.right == 0 { 1 } else { self.value }
    }
}

/// The nodes in preorder (parents before children, left before right), so that every subtree is contiguous.
fn preorder(tree: &Bvh2) -> Vec<Flat> {
    let mut list: Vec<Flat> = Vec::with_capacity(tree.nodes.len());
    let mut open = vec![(0u32, None)];
    while let Some((node, parent)) = open.pop() {
        let here = list.len() as u32;
        if let Some(parent) = parent {
            list[parent as usize].right = here - parent;
        }
        let binary = &tree.nodes[node as usize];
        let mut value = 0;
        if binary.is_leaf() {
            value = tree.primitive_indices[binary.first_index as usize];
        } else {
            open.push((binary.first_index + 1, Some(here)));
            open.push((binary.first_index, None));
        }
        list.push(Flat { hull: *binary.aabb(), right: 0, value });
    }
    for i in (0..list.len()).rev() {
        if list[i].right != 0 {
            list[i].value = list[i + 1].count() + list[i + list[i].right as usize].count();
        }
    }
    list
}

/// The cheapest ways to represent a subtree as at most 1, 2, … 7 children of a wide node.
#[derive(Clone, Copy)]
struct CollapseCost {
    cost: [f32; 7],
    /// How many of i + 2 children come from the left subtree, for i + 2 = 2 … 8; 0 if one child fewer is no worse.
    left: [u8; 7],
    /// Whether a single child is a block rather than a node.
    block: bool,
}

impl CollapseCost {
    const LEAF: Self = Self { cost: [0.0; 7], left: [0; 7], block: true };

    fn triangle(hull: &Aabb) -> Self {
        Self { cost: [hull.half_area() * LEAF_COST; 7], ..Self::LEAF }
    }

    fn of(node: &Flat, left: &Self, right: &Self) -> Self {
        let area = node.hull.half_area();
        let mut plan = Self::LEAF;
        let (mut shared, mut split) = ([0.0; 7], [0; 7]);
        for i in 0..7 {
            (shared[i], split[i]) = share(left, right, i + 2);
        }
        let inner = area + shared[6];
        plan.block = node.count() <= LEAF_SIZE && area * LEAF_COST <= inner;
        plan.cost[0] = if plan.block { area * LEAF_COST } else { inner };
        for i in 0..6 {
            let better = shared[i] < plan.cost[i];
            plan.cost[i + 1] = if better { shared[i] } else { plan.cost[i] };
            plan.left[i] = if better { split[i] } else { 0 };
        }
        plan.left[6] = split[6];
        plan
    }
}

/// The cheapest way to divide 2 … 8 children between two subtrees: its cost, and how many the left one gets.
#[inline]
fn share(left: &CollapseCost, right: &CollapseCost, children: usize) -> (f32, u8) {
    let mut best = (f32::INFINITY, 1);
    for k in 1..children {
        let cost = left.cost[k - 1] + right.cost[children - k - 1];
        if cost < best.0 {
            best = (cost, k as u8);
        }
    }
    best
}

/// Computes the plans of a subtree and all its descendants. Up to `levels` levels of recursion may use other threads.
fn solve(flat: &[Flat], plans: &mut [CollapseCost], levels: u32) {
    #[cfg(feature = "parallel")]
    if levels > 0 && flat.len() > PARALLEL {
        let right = flat[0].right as usize;
        let (near, far) = plans.split_at_mut(right);
        rayon::join(
            || solve(&flat[1..right], &mut near[1..], levels - 1),
            || solve(&flat[right..], far, levels - 1),
        );
        near[0] = CollapseCost::of(&flat[0], &near[1], &far[0]);
        return;
    }
    let _ = levels;
    for i in (0..flat.len()).rev() {
        plans[i] = match flat[i].right as usize {
            0 => CollapseCost::triangle(&flat[i].hull),
            right => CollapseCost::of(&flat[i], &plans[i + 1], &plans[i + right]),
        };
    }
}

fn emit(flat: &[Flat], plans: &[CollapseCost], ids: &[u32], triangles: &[[Vec3; 3]]) -> Wide {
    let mut wide = Wide { lines: Node::NONE.lines().to_vec(), depth: 1 };
    let mut work = vec![(0usize, 0usize, 1usize)];
    let (mut children, mut placed) = (Vec::with_capacity(8), Vec::with_capacity(8));
    while let Some((at, node, level)) = work.pop() {
        wide.depth = wide.depth.max(level);
        children.clear();
        gather(flat, plans, node, &mut children);
        placed.clear();
        for &child in &children {
            let line = wide.lines.len();
            let reference = if plans[child].block {
                wide.lines.extend(block(&flat[child..], ids, triangles).lines());
                Child::block(line)
            } else {
                work.push((line, child, level + 1));
                wide.lines.extend(Node::NONE.lines());
                Child::node(line)
            };
            placed.push((&flat[child].hull, reference));
        }
        // For unordered traversal, small boxes come first: occlusion rays terminate sooner at nearby small objects than
        // at large ones. Boxes of similar size keep their spatial order.
        placed.sort_by_key(|(hull, _)| hull.half_area().to_bits() >> 23);
        let mut made = Node::NONE;
        for (i, (hull, reference)) in placed.iter().enumerate() {
            made.set(i, Vec3::from(hull.min), Vec3::from(hull.max), *reference);
        }
        wide.lines[at..at + Node::LINES].copy_from_slice(made.lines());
    }
    wide
}

/// The subtrees that become children of the wide node made of `node`.
fn gather(flat: &[Flat], plans: &[CollapseCost], node: usize, children: &mut Vec<usize>) {
    let k = usize::from(plans[node].left[6]);
    let mut open = [(0, 0); 8];
    open[0] = (node + flat[node].right as usize, 8 - k);
    open[1] = (node + 1, k);
    let mut height = 2;
    while height > 0 {
        height -= 1;
        let (node, mut slots) = open[height];
        while slots > 1 && plans[node].left[slots - 2] == 0 {
            slots -= 1;
        }
        if slots == 1 {
            children.push(node);
            continue;
        }
        let k = usize::from(plans[node].left[slots - 2]);
        open[height] = (node + flat[node].right as usize, slots - k);
        open[height + 1] = (node + 1, k);
        height += 2;
    }
}

/// The triangles of a subtree in increasing order of id.
fn block(subtree: &[Flat], ids: &[u32], triangles: &[[Vec3; 3]]) -> Block {
    let count = subtree[0].count() as usize;
    let mut members: Vec<u32> =
        subtree[..2 * count - 1].iter().filter(|n| n.right == 0).map(|n| n.value).collect();
    members.sort_unstable();
    let mut block = Block::NONE;
    for (lane, &i) in members.iter().enumerate() {
        block.set(lane, ids[i as usize], &triangles[i as usize]);
    }
    block
}
