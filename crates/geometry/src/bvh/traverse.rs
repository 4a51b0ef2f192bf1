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
use super::simd::{SMALL_STACK, Stack, prefetch};
use super::triangle::{Sheared, intersect};
use super::{Candidate, Tree, TriangleHit};
use crate::Ray;
use std::mem::MaybeUninit;

/// 1 + 16 ulp.
const WIDEN: f32 = 1.0 + 16.0 * f32::EPSILON;

/// Stands for 1/0. The padding alone takes a ray longer to cross than anything is away, unless that is 1e31 times
/// further than the triangle is large.
const STEEPEST: f32 = f32::MAX / 2.0;

/// A ray in the tree's units with a direction near unit length, both by powers of two.
struct Normalised {
    o: [f32; 3],
    d: [f32; 3],
    /// 1/d, finite.
    r: [f32; 3],
    t_max: f32,
    /// Factor from its t to the caller's.
    to_caller: f64,
}

/// None where nothing can be hit.
#[inline(always)]
fn normalised(ray: &Ray, scale: f32, unscale: f64) -> Option<Normalised> {
    let (o, d) = (ray.o.to_array(), ray.d.to_array());
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    let largest = larger(larger(d[0].abs(), d[1].abs()), d[2].abs());
    let exponent = (largest.to_bits() >> 23).clamp(1, 253);
    let (length, shrink) = (f32::from_bits(exponent << 23), f32::from_bits((254 - exponent) << 23));
    let o = [o[0] * scale, o[1] * scale, o[2] * scale];
    let d = [d[0] * shrink, d[1] * shrink, d[2] * shrink];
    // NaN unless all are finite.
    let zero = (o[0] + o[1] + o[2] + (d[0] + d[1] + d[2])) * 0.0;
    if !(largest > zero && ray.t_max > zero) {
        return None;
    }
    Some(Normalised {
        o,
        d,
        r: d.map(|x| (1.0 / x).clamp(-STEEPEST, STEEPEST)),
        t_max: (f64::from(ray.t_max) * (f64::from(scale) * f64::from(length))) as f32,
        to_caller: f64::from(shrink) * unscale,
    })
}

/// What the slab test needs of a ray.
struct Slabs<L> {
    o: [L; 3],
    near: [L; 3],
    far: [L; 3],
    /// 1 if the upper plane of the axis is met first.
    upper: [usize; 3],
}

impl<L: Lanes> Slabs<L> {
    #[inline(always)]
    fn new(o: [f32; 3], r: [f32; 3]) -> Self {
        Self {
            o: [L::splat(o[0]), L::splat(o[1]), L::splat(o[2])],
            near: [L::splat(r[0]), L::splat(r[1]), L::splat(r[2])],
            far: [L::splat(r[0] * WIDEN), L::splat(r[1] * WIDEN), L::splat(r[2] * WIDEN)],
            upper: r.map(|x| (x.to_bits() >> 31) as usize),
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
    if tree.stack <= SMALL_STACK {
        let mut memory = [MaybeUninit::uninit(); 2 * SMALL_STACK];
        walk_with::<L, C, ANY>(tree, ray, candidate, &mut Stack::new(&mut memory))
    } else {
        let mut memory = vec![MaybeUninit::uninit(); 2 * tree.stack];
        walk_with::<L, C, ANY>(tree, ray, candidate, &mut Stack::new(&mut memory))
    }
}

#[inline(always)]
fn walk_with<L: Lanes, C: Candidate, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    candidate: &C,
    stack: &mut Stack,
) -> Option<TriangleHit> {
    let Normalised { o, d, r, t_max, to_caller } = normalised(ray, tree.scale, tree.unscale)?;
    let sheared = Sheared::new(o, d, r);
    let slabs = Slabs::<L>::new(o, r);
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
