//! From triangles to the 8-wide tree.
//!
//! Which binary nodes become children of one wide node, and which subtrees become leaves, is the cheapest choice by
//! surface area, found by the dynamic programme of [Ylitie, Karras, Laine 2017, §3].

use super::can_be_hit;
use super::node::{Block, EMPTY, LEAF, Node};
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// Most triangles in a leaf: one block.
const LEAF_SIZE: u32 = 8;
/// Cost of testing a block, in node tests.
const LEAF_COST: f32 = 0.7;
/// Box padding in units of roundoff times coordinate: covers the rounding of the slab and edge tests, so that what a
/// triangle's edges accept, no box above it rejects.
const PAD: f32 = 16.0 * crate::offset::UNIT_ROUNDOFF;

/// Nodes, blocks, the root's reference, and the traversal stack the tree can need.
pub(super) fn build(triangles: &[[Vec3; 3]]) -> (Vec<Node>, Vec<Block>, u32, usize) {
    let ids: Vec<u32> = (0..triangles.len() as u32).filter(|&i| can_be_hit(&triangles[i as usize])).collect();
    if ids.len() <= LEAF_SIZE as usize {
        let root = if ids.is_empty() { EMPTY } else { LEAF };
        let blocks = if ids.is_empty() { Vec::new() } else { vec![Block::new(&ids, triangles)] };
        return (Vec::new(), blocks, root, 8);
    }
    let boxes = padded_boxes(&ids, triangles);
    let binary = binary_tree(&boxes);
    Collapse::new(&binary).emit(&ids, triangles)
}

fn padded_boxes(ids: &[u32], triangles: &[[Vec3; 3]]) -> Vec<Aabb> {
    let tight = |id: u32| {
        let [a, b, c] = triangles[id as usize];
        (a.min(b).min(c), a.max(b).max(c))
    };
    let (low, high) =
        ids.iter().map(|&id| tight(id)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default();
    let pad = Vec3::splat(((high - low).max_element() + low.abs().max(high.abs()).max_element()) * PAD);
    ids.iter()
        .map(|&id| {
            let (min, max) = tight(id);
            Aabb::new(Vec3A::from(min - pad), Vec3A::from(max + pad))
        })
        .collect()
}

fn binary_tree(boxes: &[Aabb]) -> Bvh2 {
    let n = boxes.len();
    let order = (0..n as u32).collect();
    let (search, effort) = match n {
        0..=200_000 => (PlocSearchDistance::Medium, 0.15),
        200_001..=2_000_000 => (PlocSearchDistance::Low, 0.06),
        _ => (PlocSearchDistance::Low, 0.01),
    };
    let mut tree = PlocBuilder::with_capacity(n).build(search, boxes, order, SortPrecision::U64, 1);
    ReinsertionOptimizer::default().run(&mut tree, effort, None);
    tree
}

/// Best way to show a binary node as at most i + 1 children of a wide node.
#[derive(Clone, Copy)]
enum Way {
    /// One leaf.
    Leaf,
    /// One wide node.
    Inner,
    /// As with one child fewer.
    Fewer,
    /// This many from the left subtree, the rest from the right.
    Split(u8),
}

struct Collapse<'a> {
    tree: &'a Bvh2,
    cost: Vec<[f32; 7]>,
    way: Vec<[Way; 7]>,
    /// How the node itself splits when it becomes a wide node with 8 slots.
    inner_split: Vec<u8>,
    count: Vec<u32>,
}

impl<'a> Collapse<'a> {
    fn new(tree: &'a Bvh2) -> Self {
        let n = tree.nodes.len();
        let mut this = Self {
            tree,
            cost: vec![[0.0; 7]; n],
            way: vec![[Way::Fewer; 7]; n],
            inner_split: vec![1; n],
            count: vec![1; n],
        };
        for node in post_order(tree) {
            this.decide(node as usize);
        }
        this
    }

    fn decide(&mut self, node: usize) {
        let binary = &self.tree.nodes[node];
        let area = binary.aabb().half_area();
        if binary.is_leaf() {
            self.cost[node] = [area * LEAF_COST; 7];
            self.way[node][0] = Way::Leaf;
            return;
        }
        let (l, r) = (binary.first_index as usize, binary.first_index as usize + 1);
        self.count[node] = self.count[l] + self.count[r];
        let (inner, split) = self.distribute(l, r, 8);
        self.inner_split[node] = split;
        let (inner, leaf) = (area + inner, area * LEAF_COST);
        let is_leaf = self.count[node] <= LEAF_SIZE && leaf <= inner;
        self.cost[node][0] = if is_leaf { leaf } else { inner };
        self.way[node][0] = if is_leaf { Way::Leaf } else { Way::Inner };
        for i in 1..7 {
            let (cost, split) = self.distribute(l, r, i + 1);
            let better = cost < self.cost[node][i - 1];
            self.cost[node][i] = if better { cost } else { self.cost[node][i - 1] };
            self.way[node][i] = if better { Way::Split(split) } else { Way::Fewer };
        }
    }

    /// Cheapest way to share `slots` between two subtrees.
    fn distribute(&self, l: usize, r: usize, slots: usize) -> (f32, u8) {
        let mut best = (f32::INFINITY, 1);
        for k in 1..slots {
            let cost = self.cost[l][k - 1] + self.cost[r][slots - k - 1];
            if cost < best.0 {
                best = (cost, k as u8);
            }
        }
        best
    }

    fn emit(&self, ids: &[u32], triangles: &[[Vec3; 3]]) -> (Vec<Node>, Vec<Block>, u32, usize) {
        let (mut nodes, mut blocks) = (vec![Node::NONE], Vec::new());
        let mut work = vec![(0usize, 0usize, 1usize)];
        let mut depth = 1;
        while let Some((slot, binary, level)) = work.pop() {
            depth = depth.max(level);
            for (i, (child, is_leaf)) in self.children(binary).into_iter().enumerate() {
                let aabb = self.tree.nodes[child].aabb();
                let reference = if is_leaf {
                    blocks.push(Block::new(&self.primitives(child, ids), triangles));
                    LEAF | (blocks.len() as u32 - 1)
                } else {
                    nodes.push(Node::NONE);
                    work.push((nodes.len() - 1, child, level + 1));
                    nodes.len() as u32 - 1
                };
                nodes[slot].set(i, Vec3::from(aabb.min), Vec3::from(aabb.max), reference);
            }
        }
        (nodes, blocks, 0, 7 * depth + 8)
    }

    /// The binary nodes that become children of wide node `binary`, and whether each is a leaf.
    fn children(&self, binary: usize) -> Vec<(usize, bool)> {
        let first = self.tree.nodes[binary].first_index as usize;
        let k = self.inner_split[binary] as usize;
        let mut open = vec![(first + 1, 8 - k), (first, k)];
        let mut found = Vec::with_capacity(8);
        while let Some((node, slots)) = open.pop() {
            match self.way[node][slots - 1] {
                Way::Leaf => found.push((node, true)),
                Way::Inner => found.push((node, false)),
                Way::Fewer => open.push((node, slots - 1)),
                Way::Split(k) => {
                    let first = self.tree.nodes[node].first_index as usize;
                    open.push((first + 1, slots - k as usize));
                    open.push((first, k as usize));
                }
            }
        }
        found
    }

    fn primitives(&self, node: usize, ids: &[u32]) -> Vec<u32> {
        let (mut open, mut found) = (vec![node], Vec::with_capacity(8));
        while let Some(node) = open.pop() {
            let binary = &self.tree.nodes[node];
            if binary.is_leaf() {
                found.push(ids[self.tree.primitive_indices[binary.first_index as usize] as usize]);
            } else {
                open.extend([binary.first_index as usize + 1, binary.first_index as usize]);
            }
        }
        found.sort_unstable();
        found
    }
}

/// Children before parents.
fn post_order(tree: &Bvh2) -> Vec<u32> {
    let (mut open, mut order) = (vec![0u32], Vec::with_capacity(tree.nodes.len()));
    while let Some(node) = open.pop() {
        order.push(node);
        let binary = &tree.nodes[node as usize];
        if !binary.is_leaf() {
            open.extend([binary.first_index, binary.first_index + 1]);
        }
    }
    order.reverse();
    order
}
