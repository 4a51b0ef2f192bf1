//! Traversal of the tree: nearest child first, with the entry distance on the stack.
//!
//! The slab test needs no epsilon. (plane − o)·(1/d) has a relative error of 3 roundings on either side, and a ray may
//! pass a triangle that f32 accepts at a distance of 4 roundings relative to plane − o (the remaining error is in the
//! padding of the boxes), so the exit is widened by more than their sum. A ray in the plane of a face gives 0·∞ = NaN,
//! which min and max would discard [Ize 2013]. Because 1/0 is clamped to a finite number, the result is 0 instead,
//! which excludes the ray only where the plane bounds the far side of the box, and only padding is there. Boxes entered
//! at the nearest distance so far, or slightly beyond it, are still visited, because a triangle of lower id at the same
//! t may be in them. A box is entered if its entry is strictly before its exit. As exits are widened, the two are equal
//! only for a box at whose end the ray starts, which has only padding in front of the ray, and for a box further away
//! than the range of f32.
//!
//! Traversal is bound by latency: from a reference to the planes of its node, through the slab test to the mask of the
//! entered boxes, and from the mask to the next reference. Every cycle on this critical path matters; other
//! instructions hardly do.

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
pub(super) const WIDEN: f32 = 1.0 + 16.0 * f32::EPSILON;

/// The operands of the slab test: the ray, and for each axis the rows of the planes that the ray meets first and last.
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
        let signs = query.d.is_negative_bitmask() as usize;
        let upper = [signs & 1, signs >> 1 & 1, signs >> 2];
        Self {
            o: splat(query.o),
            near: splat(r),
            far: splat(r * WIDEN),
            first: rows(tree, upper),
            last: rows(tree, [1 - upper[0], 1 - upper[1], 1 - upper[2]]),
        }
    }

    /// Entry and exit distances of the eight boxes; a box is entered if entry < exit.
    #[inline(always)]
    fn slab_test(&self, node: Child, limit: L) -> (L, L) {
        let [near_x, near_y, near_z] = distances(node, &self.first, &self.o, &self.near);
        let [far_x, far_y, far_z] = distances(node, &self.last, &self.o, &self.far);
        let entry = near_x.later(near_y).later(near_z.later(L::splat(0.0)));
        (entry, far_x.earlier(far_y).earlier(far_z.earlier(limit)))
    }
}

#[inline(always)]
fn splat<L: Lanes>(v: Vec3A) -> [L; 3] {
    [L::splat(v.x), L::splat(v.y), L::splat(v.z)]
}

/// For each axis the row of the minima (0) or maxima (1).
#[inline(always)]
fn rows(tree: &Tree, upper: [usize; 3]) -> [BoundsRow<'_>; 3] {
    let memory = &tree.memory;
    [memory.row(upper[0]), memory.row(2 + upper[1]), memory.row(4 + upper[2])]
}

/// Distances along the ray to one plane per axis of the eight boxes of `node`.
#[inline(always)]
fn distances<L: Lanes>(node: Child, rows: &[BoundsRow; 3], o: &[L; 3], inverse: &[L; 3]) -> [L; 3] {
    [
        L::load(rows[0].of(node)).sub(o[0]).mul(inverse[0]),
        L::load(rows[1].of(node)).sub(o[1]).mul(inverse[1]),
        L::load(rows[2].of(node)).sub(o[2]).mul(inverse[2]),
    ]
}

/// The best hit so far.
struct Best<L> {
    hit: TriangleHit,
    found: bool,
    /// Boxes entered beyond this distance contain no better hit.
    limit: L,
}

/// The nearest accepted hit, or with `ANY` the first accepted hit found.
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
    // No id is lower than 0, so that there is no hit at t_max itself.
    let hit = TriangleHit { t: query.t_max, u: 0.0, v: 0.0, triangle: 0 };
    let mut best = Best { hit, found: false, limit: L::splat(query.t_max * WIDEN) };
    let mut at = tree.memory.root()?;
    if !at.is_block() {
        at = descend::<L, ANY>(tree, &slabs, at, best.limit, stack)?;
    }
    // The shear for triangle blocks is computed while the root node is loaded.
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

/// The child of `node` to visit next; the other children entered before `limit` are put on the stack.
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
    if ANY { near.first(far, children, stack, ahead) } else { near.nearest(far, children, stack, ahead) }
}

/// Searches a block for a better hit, or with `ANY` for any hit.
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

/// Removes children from the stack up to the first whose box is entered at `limit` or before, and returns it.
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
pub(super) fn in_callers_units(hit: TriangleHit, to_caller: f64) -> TriangleHit {
    let t = (f64::from(hit.t) * to_caller) as f32;
    TriangleHit { t: t.clamp(f32::from_bits(1), f32::MAX), ..hit }
}
