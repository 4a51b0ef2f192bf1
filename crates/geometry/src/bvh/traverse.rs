//! Walking the tree: nearest child first, with the entry distance on the stack.
//!
//! The slab test needs no epsilon: (plane − o)·(1/d) has a relative error of 3 roundings on either side, and a triangle
//! that f32 accepts may be passed at a distance of 4 roundings relative to plane − o (the rest is in the padding of the
//! boxes), so the exit is widened by more than their sum. A ray in the plane of a face gives 0·∞ = NaN there, which
//! min and max would drop [Ize 2013]; with 1/0 held to a finite number it is 0, which shuts the ray out only where the
//! plane bounds the far side of the box, and there is nothing on it but padding. Boxes entered at the best distance, or
//! a little beyond, are visited still: a triangle of lower id at the same t may lie there.

use super::lanes::Lanes;
use super::node::{Block, LEAF, Node};
use super::query::Query;
use super::simd::{SMALL_STACK, Stack, prefetch};
use super::triangle::{Sheared, intersect};
use super::{Candidate, Tree, TriangleHit};
use crate::Ray;
use glam::Vec3A;
use std::mem::MaybeUninit;

/// 1 + 16 ulp.
const WIDEN: f32 = 1.0 + 16.0 * f32::EPSILON;

/// What the slab test needs of a ray.
struct Slabs<L> {
    o: [L; 3],
    near: [L; 3],
    far: [L; 3],
    /// Lowest bit set if the upper plane of the axis is met first.
    upper: [usize; 3],
}

impl<L: Lanes> Slabs<L> {
    #[inline(always)]
    fn new(query: &Query, r: Vec3A) -> Self {
        let splat = |v: Vec3A| [L::splat(v.x), L::splat(v.y), L::splat(v.z)];
        let signs = query.d.is_negative_bitmask() as usize;
        Self {
            o: splat(query.o),
            near: splat(r),
            far: splat(r * WIDEN),
            upper: [signs, signs >> 1, signs >> 2],
        }
    }

    /// Entry and exit distances of the eight boxes; a box is met where entry ≤ exit.
    #[inline(always)]
    fn meet(&self, node: &Node, limit: L) -> (L, L) {
        let nx = plane(node, self.upper[0] & 1, self.o[0], self.near[0]);
        let ny = plane(node, 2 + (self.upper[1] & 1), self.o[1], self.near[1]);
        let nz = plane(node, 4 + (self.upper[2] & 1), self.o[2], self.near[2]);
        let fx = plane(node, 1 - (self.upper[0] & 1), self.o[0], self.far[0]);
        let fy = plane(node, 3 - (self.upper[1] & 1), self.o[1], self.far[1]);
        let fz = plane(node, 5 - (self.upper[2] & 1), self.o[2], self.far[2]);
        (nx.later(ny).later(nz.later(L::splat(0.0))), fx.earlier(fy).earlier(fz.earlier(limit)))
    }
}

#[inline(always)]
fn plane<L: Lanes>(node: &Node, row: usize, o: L, inverse: L) -> L {
    L::load(&node.bounds[row]).sub(o).mul(inverse)
}

/// The nearest hit that counts, or with `ANY` the first that is found.
#[inline(always)]
pub(super) fn walk<L: Lanes, C: Candidate, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    candidate: &C,
) -> Option<TriangleHit> {
    let query = Query::new(tree, ray)?;
    if query.in_range() && tree.stack <= SMALL_STACK {
        let mut memory = [MaybeUninit::uninit(); 2 * SMALL_STACK];
        return walk_with::<L, C, ANY>(tree, query, candidate, &mut Stack::new(&mut memory));
    }
    let mut small = [MaybeUninit::uninit(); 2 * SMALL_STACK];
    let mut large = Vec::new();
    let memory = if tree.stack <= SMALL_STACK {
        &mut small[..]
    } else {
        large.resize(2 * tree.stack, MaybeUninit::uninit());
        &mut large[..]
    };
    walk_with::<L, C, ANY>(tree, query.shortened(tree, ray), candidate, &mut Stack::new(memory))
}

#[inline(always)]
fn walk_with<L: Lanes, C: Candidate, const ANY: bool>(
    tree: &Tree,
    query: Query,
    candidate: &C,
    stack: &mut Stack,
) -> Option<TriangleHit> {
    let Query { o, d, t_max, to_caller, .. } = query;
    let r = query.inverse();
    let slabs = Slabs::<L>::new(&query, r);
    let sheared = Sheared::new(o, d, r);
    // No id is lower than 0: at t_max itself there is no hit.
    let mut best = TriangleHit { t: t_max, u: 0.0, v: 0.0, triangle: 0 };
    let mut found = false;
    let mut limit = L::splat(t_max * WIDEN);
    let mut at = tree.root?;
    loop {
        let mut next = None;
        if at & LEAF == 0 {
            let node = Node::read(&tree.lines, at);
            let (near, far) = slabs.meet(node, limit);
            next = if ANY {
                near.any(far, &node.child, stack, |child| prefetch(&tree.lines, child))
            } else {
                near.nearest(far, &node.child, stack, |child| prefetch(&tree.lines, child))
            };
        } else {
            let block = Block::read(&tree.lines, at & !LEAF);
            if let Some(hits) = intersect::<L>(&sheared, block, best.t) {
                let mut mask = hits.mask;
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize & 7;
                    mask &= mask - 1;
                    let Some(hit) = hits.hit(&sheared, block, lane, best.t, t_max) else { continue };
                    let nearer = hit.t < best.t || (hit.t == best.t && hit.triangle < best.triangle);
                    if nearer && (C::OPAQUE || candidate.accept(&in_callers_units(hit, to_caller))) {
                        if ANY {
                            return Some(hit);
                        }
                        best = hit;
                        found = true;
                        limit = L::splat(hit.t * WIDEN);
                    }
                }
            }
        }
        let next = match next {
            Some(child) => Some(child),
            None if ANY => stack.pop_child(),
            None => pop_within(stack, best.t * WIDEN),
        };
        let Some(child) = next else { return found.then(|| in_callers_units(best, to_caller)) };
        at = child;
    }
}

/// The child last pushed whose box is entered at `limit` or before.
#[inline(always)]
fn pop_within(stack: &mut Stack, limit: f32) -> Option<u32> {
    loop {
        let (near, child) = stack.pop()?;
        if f32::from_bits(near) <= limit {
            return Some(child);
        }
    }
}

#[inline(always)]
fn in_callers_units(hit: TriangleHit, to_caller: f64) -> TriangleHit {
    let t = (f64::from(hit.t) * to_caller) as f32;
    TriangleHit { t: t.clamp(f32::from_bits(1), f32::MAX), ..hit }
}
