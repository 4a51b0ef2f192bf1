//! A binary tree from the top down: at every node the best of all splits of the boxes sorted along each axis.
//!
//! Sweep builder of the surface area heuristic [MacDonald & Booth 1990], with one change: a side of n triangles is
//! taken to cost n^0.6875 times its area, not n. The linear cost would hold if each side became a leaf; a side that is
//! split further costs less the more there is in it. Where boxes overlap much, that takes off one at a time: below a
//! depth that no other tree needs, costs are linear. Rays then visit a tenth fewer nodes and blocks of a terrain, and
//! no more of a room, than in a bottom-up tree with reinsertion (`benches/README.md`).

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};

/// The tree over `boxes`, at least one, with one of them per leaf.
pub(super) fn sweep(boxes: &[Aabb]) -> Bvh2 {
    let mut sweep = Sweep::new(boxes);
    let mut tree = Bvh2::default();
    tree.nodes.push(Bvh2Node::default());
    let depths = boxes.len().ilog2();
    let mut open = vec![Range { node: 0, first: 0, end: boxes.len(), depth: 0 }];
    while let Some(part) = open.pop() {
        let hull = sweep.hull(&part);
        if part.end - part.first == 1 {
            tree.nodes[part.node] = Bvh2Node::new(hull, 1, tree.primitive_indices.len() as u32);
            tree.primitive_indices.push(sweep.order[0][part.first]);
            continue;
        }
        let middle = sweep.split(
            &part,
            match part.depth {
                depth if depth < depths + 12 => Rule::Sublinear,
                depth if depth < 2 * depths + 24 => Rule::Linear,
                _ => Rule::Middle,
            },
        );
        let left = tree.nodes.len();
        tree.nodes.extend([Bvh2Node::default(); 2]);
        tree.nodes[part.node] = Bvh2Node::new(hull, 0, left as u32);
        let depth = part.depth + 1;
        open.push(Range { node: left + 1, first: middle, end: part.end, depth });
        open.push(Range { node: left, first: part.first, end: middle, depth });
    }
    tree
}

/// Where a node is split.
#[derive(Clone, Copy, PartialEq)]
enum Rule {
    Sublinear,
    Linear,
    /// In the middle of the longest row of centres: coincident boxes make no other rule end soon.
    Middle,
}

/// The boxes of one node: `first..end` in each of the three orders.
struct Range {
    node: usize,
    first: usize,
    end: usize,
    depth: u32,
}

struct Sweep<'a> {
    boxes: &'a [Aabb],
    /// Boxes by their centre along each axis.
    order: [Vec<u32>; 3],
    /// By count: what a side of so many boxes costs per area.
    cost: Vec<f32>,
    /// By place in an order: cost of what lies from there to the end of the part.
    beyond: Vec<f32>,
    /// By box: whether it goes to the right.
    right: Vec<bool>,
    moved: Vec<u32>,
}

impl<'a> Sweep<'a> {
    fn new(boxes: &'a [Aabb]) -> Self {
        let n = boxes.len();
        let centre = |i: u32| boxes[i as usize].min + boxes[i as usize].max;
        let order = [Vec3A::X, Vec3A::Y, Vec3A::Z].map(|axis| {
            let mut order: Vec<u32> = (0..n as u32).collect();
            order.sort_by(|&a, &b| centre(a).dot(axis).total_cmp(&centre(b).dot(axis)));
            order
        });
        let cost = (0..=n)
            .map(|n| {
                let root = (n as f32).sqrt();
                let eighth = root.sqrt().sqrt();
                root * eighth * eighth.sqrt()
            })
            .collect();
        Self { boxes, order, cost, beyond: vec![0.0; n], right: vec![false; n], moved: Vec::with_capacity(n) }
    }

    fn at(&self, axis: usize, place: usize) -> &'a Aabb {
        &self.boxes[self.order[axis][place] as usize]
    }

    fn hull(&self, part: &Range) -> Aabb {
        (part.first + 1..part.end).fold(*self.at(0, part.first), |hull, i| hull.union(self.at(0, i)))
    }

    /// Brings the boxes of the left side to the front of every order and says where the right side begins.
    fn split(&mut self, part: &Range, rule: Rule) -> usize {
        let (axis, middle) = match rule {
            Rule::Sublinear => self.cheapest(part, |cost, n| cost[n]),
            Rule::Linear => self.cheapest(part, |_, n| n as f32),
            Rule::Middle => self.middle(part),
        };
        for place in part.first..part.end {
            self.right[self.order[axis][place] as usize] = place >= middle;
        }
        for other in (0..3).filter(|&other| other != axis) {
            let row = &mut self.order[other][part.first..part.end];
            self.moved.clear();
            self.moved.extend(row.iter().filter(|&&i| !self.right[i as usize]));
            self.moved.extend(row.iter().filter(|&&i| self.right[i as usize]));
            row.copy_from_slice(&self.moved);
        }
        middle
    }

    fn cheapest(&mut self, part: &Range, cost: impl Fn(&[f32], usize) -> f32) -> (usize, usize) {
        let mut best = (f32::INFINITY, 0, part.first + 1);
        for axis in 0..3 {
            let mut hull = *self.at(axis, part.end - 1);
            for place in (part.first + 1..part.end).rev() {
                hull = hull.union(self.at(axis, place));
                self.beyond[place] = hull.half_area() * cost(&self.cost, part.end - place);
            }
            let mut hull = *self.at(axis, part.first);
            for place in part.first + 1..part.end {
                let sum = hull.half_area() * cost(&self.cost, place - part.first) + self.beyond[place];
                if sum < best.0 {
                    best = (sum, axis, place);
                }
                hull = hull.union(self.at(axis, place));
            }
        }
        (best.1, best.2)
    }

    fn middle(&self, part: &Range) -> (usize, usize) {
        let extent = |axis: usize| {
            let centre = |b: &Aabb| b.min[axis] + b.max[axis];
            centre(self.at(axis, part.end - 1)) - centre(self.at(axis, part.first))
        };
        let longest = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
        (longest, part.first + (part.end - part.first) / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(x: f32) -> Aabb {
        Aabb::new(Vec3A::splat(x), Vec3A::splat(x + 0.5))
    }

    /// Every box once, in a leaf of its own, and every node around its children.
    fn check(boxes: &[Aabb], deepest: usize) {
        let tree = sweep(boxes);
        let mut seen: Vec<u32> = tree.primitive_indices.clone();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..boxes.len() as u32));
        let mut open = vec![(0, 1)];
        let mut leaves = 0;
        while let Some((at, depth)) = open.pop() {
            assert!(depth <= deepest, "{depth}");
            let node = &tree.nodes[at];
            let first = node.first_index as usize;
            if node.is_leaf() {
                leaves += 1;
                assert_eq!(*node.aabb(), boxes[tree.primitive_indices[first] as usize]);
            } else {
                let both = tree.nodes[first].aabb().union(tree.nodes[first + 1].aabb());
                assert_eq!(*node.aabb(), both);
                open.extend([(first, depth + 1), (first + 1, depth + 1)]);
            }
        }
        assert_eq!(leaves, boxes.len());
    }

    #[test]
    fn holds_every_box_once() {
        check(&[cube(0.0)], 1);
        check(&(0..100).map(|i| cube((i * 37 % 100) as f32)).collect::<Vec<_>>(), 12);
    }

    #[test]
    fn coincident_boxes_do_not_make_it_deep() {
        check(&vec![cube(0.0); 4096], 2 * 12 + 24 + 12 + 2);
    }
}
