//! The hits of a packet: the best so far, and the triangles that f64 has to decide.

use super::columns::Columns;
use crate::bvh::hit_filter::TriangleHit;
use crate::bvh::lanes::PerRay;
use crate::bvh::leaves::Leaf;
use crate::bvh::triangle::{Crossed, decide};
use dapple_math::lanes::{MAX_LANES, Mask, Real, Word};

/// The best hits so far.
pub(super) struct Best<R: Real> {
    pub found: R::Mask,
    pub t: R,
    v: R,
    w: R,
    det: R,
    triangle: R::Word,
}

impl<R: Real> Best<R> {
    #[inline(always)]
    pub fn new(t_max: R) -> Self {
        let (zero, one, none) = (R::splat(0.0), R::splat(1.0), R::Mask::splat(false));
        // No id is lower than 0, so that there is no hit at t_max itself.
        Self { found: none, t: t_max, v: zero, w: zero, det: one, triangle: R::Word::splat(0) }
    }

    /// Takes those hits on a triangle that are better; with `ANY` it is enough that there are hits.
    #[inline(always)]
    pub fn take<const ANY: bool>(&mut self, hit: R::Mask, t: R, crossed: &Crossed<PerRay<R>>, triangle: u32) {
        let triangle = R::Word::splat(triangle);
        let nearer = hit & (t.lt(self.t) | (t.eq(self.t) & triangle.lt(self.triangle)));
        self.found = self.found | nearer;
        if !ANY {
            self.t = R::select(nearer, t, self.t);
            self.v = R::select(nearer, crossed.v.0, self.v);
            self.w = R::select(nearer, crossed.w.0, self.w);
            self.det = R::select(nearer, crossed.det.0, self.det);
            self.triangle = R::Word::select(nearer, triangle, self.triangle);
        }
    }

    #[inline(always)]
    pub fn hits(&self) -> Hits {
        let mut hits = Hits::NONE;
        hits.found = self.found.bitmask();
        self.t.store(&mut hits.t);
        (self.v / self.det).store(&mut hits.u);
        (self.w / self.det).store(&mut hits.v);
        self.triangle.store(&mut hits.triangle);
        hits
    }
}

/// The number of entries of [`Open`], of which a packet needs a few.
const OPEN: usize = 64;

/// Triangles of which f64 has to decide whether rays hit them, with these rays. They are decided together and after all
/// others, because most of them are behind the hits that are then known.
pub(super) struct Open<'a> {
    len: usize,
    entries: [Option<(&'a Leaf, u32, u32)>; OPEN],
    /// Rays for which there was no room.
    pub left: u32,
}

impl<'a> Open<'a> {
    #[inline(always)]
    pub fn new() -> Self {
        Self { len: 0, entries: [None; OPEN], left: 0 }
    }

    #[inline(always)]
    pub fn clear(&mut self) {
        (self.len, self.left) = (0, 0);
    }

    /// Whether there is room for all triangles of a leaf, each twice; if not, the rays are left.
    #[inline(always)]
    pub fn has_room(&mut self, rays: u32) -> bool {
        let has_room = self.len + 16 <= OPEN;
        self.left |= if has_room { 0 } else { rays };
        has_room
    }

    /// Adds a triangle, unless there are no rays.
    #[inline(always)]
    pub fn push(&mut self, leaf: &'a Leaf, slot: usize, rays: u32) {
        self.entries[self.len % OPEN] = Some((leaf, slot as u32, rays));
        self.len += usize::from(rays != 0);
    }
}

/// The hits of a packet.
pub(super) struct Hits {
    pub found: u32,
    pub t: [f32; MAX_LANES],
    u: [f32; MAX_LANES],
    v: [f32; MAX_LANES],
    triangle: [u32; MAX_LANES],
}

impl Hits {
    pub const NONE: Self = {
        let zero = [0.0; MAX_LANES];
        Self { found: 0, t: zero, u: zero, v: zero, triangle: [0; MAX_LANES] }
    };

    #[inline(always)]
    pub fn hit(&self, lane: usize) -> TriangleHit {
        TriangleHit { t: self.t[lane], u: self.u[lane], v: self.v[lane], triangle: self.triangle[lane] }
    }

    /// Takes the hits of `open` that are better.
    #[inline(always)]
    pub fn settle<const ANY: bool>(&mut self, open: &Open, columns: &Columns) {
        for &(leaf, slot, mut rays) in open.entries.iter().take(open.len).flatten() {
            if ANY {
                rays &= !self.found;
            }
            while rays != 0 {
                let lane = rays.trailing_zeros() as usize % MAX_LANES;
                rays &= rays - 1;
                if let Some(hit) = decide(&columns.line(lane), &leaf.block, slot as usize % 8, self.t[lane]) {
                    self.improve::<ANY>(lane, hit);
                }
            }
        }
    }

    #[inline(always)]
    fn improve<const ANY: bool>(&mut self, lane: usize, hit: TriangleHit) {
        if hit.t < self.t[lane] || (hit.t == self.t[lane] && hit.triangle < self.triangle[lane]) {
            self.found |= 1 << lane;
            if !ANY {
                (self.t[lane], self.u[lane], self.v[lane]) = (hit.t, hit.u, hit.v);
                self.triangle[lane] = hit.triangle;
            }
        }
    }
}
