//! Construction of the BVH: selects the valid triangles, computes their bounding boxes, and chooses the builder by
//! quality.

use super::collapse::collapse;
use super::kernel::Kernel;
use super::leaves::leaves;
use super::memory::Memory;
use super::node::{Block, Child};
use super::sweep::sweep;
use super::tree::Tree;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// Larger coordinates are treated as errors: their magnitude would leave no precision for the rest of the mesh.
const LARGEST: f32 = (1u128 << 96) as f32;

/// Box padding, relative to the size of the box: any point that the edge tests of a triangle accept is within 6
/// roundings of its extent from the triangle (plus 4 roundings of its distance, which the slab test allows for).
const PAD: f32 = 8.0 * f32::EPSILON;

/// The effort spent on building a tree. Hits do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// For previews and edits: about 0.4 µs per triangle.
    Fast,
    /// About 1 µs per triangle.
    Medium,
    /// About 2 µs per triangle.
    High,
}

impl Quality {
    /// The highest quality for which a mesh of this many triangles builds within about a second.
    pub fn for_count(triangles: usize) -> Self {
        match triangles {
            0..=250_000 => Self::High,
            250_001..=2_000_000 => Self::Medium,
            _ => Self::Fast,
        }
    }
}

impl Tree {
    /// Builds a tree over triangles given by their corners. Triangles with a corner that is not finite or beyond 2^96,
    /// or without area (cross product in f64), keep their ids and are never hit.
    ///
    /// # Panics
    /// If nodes and blocks take more than 32 GiB, which does not happen for up to [`Tree::MOST_TRIANGLES`].
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        Self::build_with(triangles, Quality::for_count(triangles.len()))
    }

    /// As [`Tree::build`], with the given quality.
    ///
    /// # Panics
    /// As [`Tree::build`].
    pub fn build_with(triangles: &[[Vec3; 3]], quality: Quality) -> Self {
        build(triangles, quality, Kernel::fastest())
    }
}

fn build(triangles: &[[Vec3; 3]], quality: Quality, kernel: Kernel) -> Tree {
    let ids: Vec<u32> = (0u32..).zip(triangles).filter(|(_, t)| can_be_hit(t)).map(|(id, _)| id).collect();
    let bounds = bounds(&ids, triangles);
    let scale = bounds.map_or(1.0, |(low, high)| unit_scale(low.abs().max(high.abs()).max_element()));
    let scaled: Vec<[Vec3; 3]> = ids.iter().map(|&id| triangles[id as usize].map(|p| p * scale)).collect();
    let mut tree = Tree {
        memory: Memory::EMPTY,
        stack: 8,
        scale,
        unscale: 1.0 / f64::from(scale),
        bounds,
        kernel,
        triangles: ids.len(),
        leaves: Vec::new(),
    };
    match ids.len() {
        0 => {}
        1..=8 => {
            let mut block = Block::NONE;
            (0..).zip(&ids).zip(&scaled).for_each(|((lane, &id), t)| block.set(lane, id, t));
            tree.memory = Memory::new(block.lines().to_vec(), Child::block(0));
        }
        _ => {
            let boxes: Vec<Aabb> = scaled.iter().map(padded_box).collect();
            let wide = collapse(&binary_tree(&boxes, quality), &ids, &scaled);
            (tree.memory, tree.stack) = (Memory::new(wide.lines, Child::node(0)), 7 * wide.depth + 8);
        }
    }
    if ids.len() <= Kernel::MOST_IN_PACKETS {
        tree.leaves = leaves(&tree.memory);
    }
    tree
}

/// Whether a triangle has finite coordinates of at most `LARGEST` and a non-zero area.
fn can_be_hit(t: &[Vec3; 3]) -> bool {
    let [a, b, c] = t.map(|p| p.as_dvec3());
    t.iter().all(|p| p.is_finite() && p.abs().max_element() <= LARGEST) && (b - a).cross(c - a) != DVec3::ZERO
}

fn bounds(ids: &[u32], triangles: &[[Vec3; 3]]) -> Option<(Vec3, Vec3)> {
    let corners = ids.iter().flat_map(|&id| &triangles[id as usize]);
    corners.map(|&p| (p, p)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// The power of two that scales `x` > 0 into [1, 2), or as near as f32 can.
fn unit_scale(x: f32) -> f32 {
    f32::from_bits((254 - (x.to_bits() >> 23).clamp(1, 253)) << 23)
}

fn padded_box(t: &[Vec3; 3]) -> Aabb {
    let (low, high) = (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]));
    let pad = (high - low).max_element() * PAD;
    let low = (low - pad).to_array().map(f32::next_down);
    let high = (high + pad).to_array().map(f32::next_up);
    Aabb::new(Vec3A::from_array(low), Vec3A::from_array(high))
}

fn binary_tree(boxes: &[Aabb], quality: Quality) -> Bvh2 {
    match quality {
        Quality::Fast | Quality::Medium if crowding(boxes) > CROWDED => sweep(boxes),
        Quality::Fast => bottom_up(boxes, PlocSearchDistance::Low, 0.02),
        Quality::Medium => bottom_up(boxes, PlocSearchDistance::Medium, 0.15),
        Quality::High => sweep(boxes),
    }
}

/// Above this many boxes on a line that intersects all of them, the bottom-up search takes longer than the sweep: every
/// box is then a neighbour of every other, and bottom-up building takes quadratic time.
const CROWDED: f64 = 16384.0;

/// The expected number of boxes intersected by a random line that intersects their common bounding box. By Cauchy's
/// formula, surface areas are proportional to the measure of lines that intersect convex bodies.
fn crowding(boxes: &[Aabb]) -> f64 {
    let hull = boxes.iter().skip(1).fold(boxes[0], |hull, b| hull.union(b));
    let all: f64 = boxes.iter().map(|b| f64::from(b.half_area())).sum();
    all / f64::from(hull.half_area())
}

/// Builds a tree by PLOC, then reinserts the given fraction of the nodes where they cost least.
fn bottom_up(boxes: &[Aabb], search: PlocSearchDistance, effort: f32) -> Bvh2 {
    let order = (0..boxes.len() as u32).collect();
    let distinct: Vec<Aabb> = (0..).zip(boxes).map(|(i, b)| jittered(i, b)).collect();
    let mut tree =
        PlocBuilder::with_capacity(boxes.len()).build(search, &distinct, order, SortPrecision::U64, 1);
    restore(&mut tree, boxes);
    ReinsertionOptimizer::default().run(&mut tree, effort, None);
    tree
}

/// A slightly enlarged box, by a different amount for each index. PLOC joins boxes that choose each other as cheapest
/// neighbours; among equal boxes all choose the previous one, one pair is joined per pass, and building takes quadratic
/// time.
fn jittered(i: u32, b: &Aabb) -> Aabb {
    let mut x = i.wrapping_mul(0x9E37_79B9);
    x = (x ^ (x >> 15)).wrapping_mul(0x85EB_CA6B);
    let amount = ((x ^ (x >> 13)) >> 8) as f32 * (1.0 / (1 << 30) as f32);
    let grow = Vec3A::splat((b.max - b.min).max_element() * amount);
    Aabb::new(b.min - grow, b.max + grow)
}

/// Restores the original boxes, from the leaves up; children are stored after their parents.
fn restore(tree: &mut Bvh2, boxes: &[Aabb]) {
    for i in (0..tree.nodes.len()).rev() {
        let node = tree.nodes[i];
        let first = node.first_index as usize;
        let hull = if node.is_leaf() {
            boxes[tree.primitive_indices[first] as usize]
        } else {
            tree.nodes[first].aabb().union(tree.nodes[first + 1].aabb())
        };
        tree.nodes[i].set_aabb(hull);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_scale_is_a_power_of_two() {
        for x in [1e-30f32, 0.1, 1.0, 1.999, 2.0, 1e20] {
            let s = unit_scale(x);
            assert!((1.0..2.0).contains(&(x * s)) && s.to_bits() << 9 == 0, "{x}");
        }
        assert!(unit_scale(f32::from_bits(1)).is_finite() && unit_scale(f32::MAX) > 0.0);
    }

    #[test]
    fn crowding_counts_the_boxes_on_a_line() {
        let cube = |p: Vec3A, r: f32| Aabb::new(p - r, p + r);
        let nested: Vec<Aabb> = (0..100).map(|_| cube(Vec3A::ONE, 2.0)).collect();
        assert_eq!(crowding(&nested), 100.0);
        // 10 × 10 × 10 cubes without gaps: a line along an axis intersects 10, any other line more.
        let at = |i: u32| Vec3A::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32);
        let grid: Vec<Aabb> = (0..1000).map(|i| cube(at(i), 0.5)).collect();
        assert_eq!(crowding(&grid), 10.0);
    }

    #[test]
    fn what_cannot_be_hit() {
        let good = [Vec3::ZERO, Vec3::X, Vec3::Y];
        assert!(can_be_hit(&good) && can_be_hit(&good.map(|p| p * 1e-40)));
        for bad in
            [Vec3::NAN, Vec3::splat(f32::INFINITY), Vec3::splat(1e38), Vec3::X, Vec3::ZERO, Vec3::X * 0.5]
        {
            assert!(!can_be_hit(&[Vec3::ZERO, Vec3::X, bad]), "{bad}");
        }
    }
}
