//! Walking the tree: nearest child first, with the entry distance on the stack.
//!
//! The slab test needs no epsilon: (plane − o)·(1/d) has a relative error of 3 roundings on either side, and a triangle
//! that f32 accepts may be passed at a distance of 4 roundings relative to plane − o (the rest is in the padding of the
//! boxes), so the exit is widened by more than their sum. A ray in the plane of a face gives 0·∞ = NaN there, which
//! min and max would drop [Ize 2013]; with 1/0 held to a finite number it is 0, which shuts the ray out only where the
//! plane bounds the far side of the box, and there is nothing on it but padding. Boxes entered at the best distance, or
//! a little beyond, are visited still: a triangle of lower id at the same t may lie there. A box is met where its entry
//! lies before its exit, not at it: as exits are widened, the two are equal only for a box whose end the ray starts on,
//! which leaves it with nothing but padding before it, and for one further away than f32 reaches.
//!
//! The time is spent waiting: from a reference to the planes of its node, through the slab test to the mask of the boxes
//! that are met, and from the mask to the next reference. Every cycle on that way counts, instructions beside it hardly do.

use super::hit_filter::{HitFilter, TriangleHit};
use super::lanes::Lanes;
use super::memory::BoundsRow;
use super::node::{Block, Child};
use super::query::Query;
use super::stack::{SMALL_STACK, Stack};
use super::tree::Tree;
use super::triangle::{Sheared, intersect};
use dapple_math::Ray;
use glam::Vec3A;
use std::mem::MaybeUninit;

/// 1 + 16 ulp.
const WIDEN: f32 = 1.0 + 16.0 * f32::EPSILON;

/// What the slab test needs of a ray, and of the tree the planes that the ray meets first on each axis, and last.
struct Slabs<'a, L> {
    o: [L; 3],
    near: [L; 3],
    far: [L; 3],
    first: [BoundsRow<'a>; 3],
    last: [BoundsRow<'a>; 3],
}

impl<'a, L: Lanes> Slabs<'a, L> {
    #[inline(always)]
    fn new(tree: &'a Tree, query: &Query, r: Vec3A) -> Self {
        let splat = |v: Vec3A| [L::splat(v.x), L::splat(v.y), L::splat(v.z)];
        let signs = query.d.is_negative_bitmask() as usize;
        let upper = [signs & 1, signs >> 1 & 1, signs >> 2];
        let row = |axis: usize, upper: usize| tree.memory.row(2 * axis + upper);
        Self {
            o: splat(query.o),
            near: splat(r),
            far: splat(r * WIDEN),
            first: [row(0, upper[0]), row(1, upper[1]), row(2, upper[2])],
            last: [row(0, 1 - upper[0]), row(1, 1 - upper[1]), row(2, 1 - upper[2])],
        }
    }

    /// Entry and exit distances of the eight boxes; a box is met where entry < exit.
    #[inline(always)]
    fn slab_test(&self, node: Child, limit: L) -> (L, L) {
        let plane = |row: BoundsRow, o: L, inverse: L| L::load(row.of(node)).sub(o).mul(inverse);
        let near = |axis: usize| plane(self.first[axis], self.o[axis], self.near[axis]);
        let far = |axis: usize| plane(self.last[axis], self.o[axis], self.far[axis]);
        let entry = near(0).later(near(1)).later(near(2).later(L::splat(0.0)));
        (entry, far(0).earlier(far(1)).earlier(far(2).earlier(limit)))
    }
}

/// What is known of the hit so far.
struct Best<L> {
    hit: TriangleHit,
    found: bool,
    /// Boxes entered from here on have nothing better.
    limit: L,
}

/// The nearest hit that counts, or with `ANY` the first that is found.
#[inline(always)]
pub(super) fn traverse<L: Lanes, C: HitFilter<TriangleHit>, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    filter: &C,
) -> Option<TriangleHit> {
    if tree.stack <= SMALL_STACK
        && let Some(query) = Query::new(tree, ray)
    {
        let mut memory = [MaybeUninit::uninit(); 2 * SMALL_STACK];
        return traverse_with::<L, C, ANY>(tree, query, filter, &mut Stack::new(&mut memory));
    }
    let query = Query::shortened(tree, ray)?;
    let (mut small, mut large) = ([MaybeUninit::uninit(); 2 * SMALL_STACK], Vec::new());
    let memory = if tree.stack <= SMALL_STACK {
        &mut small[..]
    } else {
        large.resize(2 * tree.stack, MaybeUninit::uninit());
        &mut large[..]
    };
    traverse_with::<L, C, ANY>(tree, query, filter, &mut Stack::new(memory))
}

#[inline(always)]
fn traverse_with<L: Lanes, C: HitFilter<TriangleHit>, const ANY: bool>(
    tree: &Tree,
    query: Query,
    filter: &C,
    stack: &mut Stack,
) -> Option<TriangleHit> {
    let r = query.inverse();
    let slabs = Slabs::<L>::new(tree, &query, r);
    // No id is lower than 0: at t_max itself there is no hit.
    let hit = TriangleHit { t: query.t_max, u: 0.0, v: 0.0, triangle: 0 };
    let mut best = Best { hit, found: false, limit: L::splat(query.t_max * WIDEN) };
    let mut at = tree.memory.root()?;
    if !at.is_block() {
        at = descend::<L, ANY>(tree, &slabs, at, best.limit, stack)?;
    }
    // What blocks need of the ray is worked out while the root is waited for.
    let sheared = Sheared::new(query.o, query.d, r);
    loop {
        let mut next = None;
        if at.is_block() {
            let block = tree.memory.block(at);
            intersect_block::<L, C, ANY>(block, &query, &sheared, filter, &mut best);
            if ANY && best.found {
                return Some(best.hit);
            }
        } else {
            next = descend::<L, ANY>(tree, &slabs, at, best.limit, stack);
        }
        let next = match next {
            Some(child) => Some(child),
            None if ANY => stack.pop_child(),
            None => pop_within(stack, best.hit.t * WIDEN),
        };
        let Some(child) = next else {
            return best.found.then(|| in_callers_units(best.hit, query.to_caller));
        };
        at = child;
    }
}

/// The child of `node` to go on with; others that are entered before `limit` are on the stack.
#[inline(always)]
fn descend<L: Lanes, const ANY: bool>(
    tree: &Tree,
    slabs: &Slabs<L>,
    node: Child,
    limit: L,
    stack: &mut Stack,
) -> Option<Child> {
    let (near, far) = slabs.slab_test(node, limit);
    let (children, ahead) = (tree.memory.children(node), |child| tree.memory.prefetch(child));
    if ANY { near.any(far, children, stack, ahead) } else { near.nearest(far, children, stack, ahead) }
}

/// Looks for a better hit in a block; with `ANY` for any.
#[inline(always)]
fn intersect_block<L: Lanes, C: HitFilter<TriangleHit>, const ANY: bool>(
    block: &Block,
    query: &Query,
    sheared: &Sheared,
    filter: &C,
    best: &mut Best<L>,
) {
    let Some(hits) = intersect::<L>(sheared, block, best.hit.t) else { return };
    let mut mask = hits.mask;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & 7;
        mask &= mask - 1;
        let Some(hit) = hits.hit(sheared, block, lane, best.hit.t, query.t_max) else { continue };
        let nearer = hit.t < best.hit.t || (hit.t == best.hit.t && hit.triangle < best.hit.triangle);
        if nearer && (C::OPAQUE || filter.accept(&in_callers_units(hit, query.to_caller))) {
            *best = Best { hit, found: true, limit: L::splat(hit.t * WIDEN) };
            if ANY {
                return;
            }
        }
    }
}

/// The child last pushed whose box is entered at `limit` or before.
#[inline(always)]
fn pop_within(stack: &mut Stack, limit: f32) -> Option<Child> {
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
