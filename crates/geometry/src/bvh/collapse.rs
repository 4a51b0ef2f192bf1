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
    let groups = groups(&boxes);
    let hulls: Vec<Aabb> = groups.iter().map(|g| union(g, &boxes)).collect();
    let binary = binary_tree(&hulls);
    Collapse::new(&binary, &groups).emit(&ids, &boxes, triangles)
}

/// Boxes that share their centre, the smallest first. The binary builder cannot tell them apart and would make a chain
/// of them, in quadratic time.
fn groups(boxes: &[Aabb]) -> Vec<Vec<u32>> {
    let key = |i: u32| boxes[i as usize].center().to_array().map(f32::to_bits);
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    order.sort_by(|&a, &b| {
        let area = |i: u32| boxes[i as usize].half_area();
        key(a).cmp(&key(b)).then(area(a).total_cmp(&area(b))).then(a.cmp(&b))
    });
    let mut groups: Vec<Vec<u32>> = order.chunk_by(|&a, &b| key(a) == key(b)).map(<[u32]>::to_vec).collect();
    // Back to the order given, which often is already coherent.
    groups.sort_by_key(|g| g.iter().min().copied());
    groups
}

fn union(members: &[u32], boxes: &[Aabb]) -> Aabb {
    members.iter().fold(Aabb::INVALID, |hull, &i| hull.union(&boxes[i as usize]))
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
    groups: &'a [Vec<u32>],
    cost: Vec<[f32; 7]>,
    way: Vec<[Way; 7]>,
    /// How the node itself splits when it becomes a wide node with 8 slots.
    inner_split: Vec<u8>,
    count: Vec<u32>,
}

impl<'a> Collapse<'a> {
    fn new(tree: &'a Bvh2, groups: &'a [Vec<u32>]) -> Self {
        let n = tree.nodes.len();
        let mut this = Self {
            tree,
            groups,
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
            self.count[node] = self.group(node).len() as u32;
            self.cost[node] = [area * LEAF_COST * self.count[node].div_ceil(LEAF_SIZE) as f32; 7];
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

    fn group(&self, leaf: usize) -> &[u32] {
        let first = self.tree.nodes[leaf].first_index as usize;
        &self.groups[self.tree.primitive_indices[first] as usize]
    }

    fn emit(
        &self,
        ids: &[u32],
        boxes: &[Aabb],
        triangles: &[[Vec3; 3]],
    ) -> (Vec<Node>, Vec<Block>, u32, usize) {
        let mut out = Wide { nodes: vec![Node::NONE], blocks: Vec::new(), depth: 1 };
        if self.tree.nodes[0].is_leaf() {
            let root = out.pack(&self.members(0), ids, boxes, triangles, 0).0;
            return (out.nodes, out.blocks, root, 7 * out.depth + 8);
        }
        let mut work = vec![(0usize, 0usize, 1usize)];
        while let Some((slot, binary, level)) = work.pop() {
            out.depth = out.depth.max(level);
            for (i, (child, is_leaf)) in self.children(binary).into_iter().enumerate() {
                let (reference, hull) = if is_leaf {
                    out.pack(&self.members(child), ids, boxes, triangles, level)
                } else {
                    out.nodes.push(Node::NONE);
                    work.push((out.nodes.len() - 1, child, level + 1));
                    (out.nodes.len() as u32 - 1, *self.tree.nodes[child].aabb())
                };
                out.nodes[slot].set(i, Vec3::from(hull.min), Vec3::from(hull.max), reference);
            }
        }
        (out.nodes, out.blocks, 0, 7 * out.depth + 8)
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

    /// Boxes under a binary node.
    fn members(&self, node: usize) -> Vec<u32> {
        let (mut open, mut found) = (vec![node], Vec::with_capacity(8));
        while let Some(node) = open.pop() {
            let binary = &self.tree.nodes[node];
            if binary.is_leaf() {
                found.extend_from_slice(self.group(node));
            } else {
                open.extend([binary.first_index as usize + 1, binary.first_index as usize]);
            }
        }
        found
    }
}

/// The wide tree as it grows.
struct Wide {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
    depth: usize,
}

impl Wide {
    /// One block, or a balanced tree of blocks over boxes that cannot be told apart; its reference and its box.
    fn pack(
        &mut self,
        members: &[u32],
        ids: &[u32],
        boxes: &[Aabb],
        triangles: &[[Vec3; 3]],
        level: usize,
    ) -> (u32, Aabb) {
        let mut row: Vec<(u32, Aabb)> = Vec::new();
        for chunk in members.chunks(LEAF_SIZE as usize) {
            let mut lanes: Vec<u32> = chunk.iter().map(|&i| ids[i as usize]).collect();
            lanes.sort_unstable();
            self.blocks.push(Block::new(&lanes, triangles));
            row.push((LEAF | (self.blocks.len() as u32 - 1), union(chunk, boxes)));
        }
        let mut depth = level;
        while row.len() > 1 {
            depth += 1;
            row = row.chunks(8).map(|children| self.join(children)).collect();
        }
        self.depth = self.depth.max(depth + 1);
        row[0]
    }

    fn join(&mut self, children: &[(u32, Aabb)]) -> (u32, Aabb) {
        let mut node = Node::NONE;
        for (i, (reference, hull)) in children.iter().enumerate() {
            node.set(i, Vec3::from(hull.min), Vec3::from(hull.max), *reference);
        }
        self.nodes.push(node);
        let hull = children.iter().fold(Aabb::INVALID, |hull, c| hull.union(&c.1));
        (self.nodes.len() as u32 - 1, hull)
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
