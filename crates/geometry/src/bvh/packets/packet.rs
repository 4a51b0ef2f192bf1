//! One packet of rays, and its way through the leaves of a tree.

use super::columns::Columns;
use super::hits::{Best, Hits, Open};
use crate::bvh::lanes::PerRay;
use crate::bvh::leaves::Leaf;
use crate::bvh::query::STEEPEST;
use crate::bvh::traverse::WIDEN;
use crate::bvh::triangle::{AXES, Corner, Crossed, DOUBT, LARGEST, corner, doubt, is_near_end};
use dapple_math::lanes::{Mask, Real, Vec3x};

/// What the tests need of the rays.
pub(super) struct Packet<R: Real> {
    live: R::Mask,
    o: Vec3x<R>,
    /// 1/d, finite.
    inverse: Vec3x<R>,
    t_max: R,
    /// The axes in the order of the shear, the origin in that order, the shear, and 1/d on the main axis.
    k: [usize; 3],
    sheared: [PerRay<R>; 3],
    s: [PerRay<R>; 2],
    along: R,
    /// Upper bound of the uncertainty of any distance to a triangle.
    doubt: R,
}

impl<R: Real> Packet<R> {
    /// The first rays of the columns, one per lane, with the given main axis.
    #[inline(always)]
    pub fn new(columns: &Columns, axis: usize) -> Self {
        let k = AXES[axis];
        let ([x, y, z], [dx, dy, dz]) = (&columns.o, &columns.d);
        let o = Vec3x::new(R::load(x), R::load(y), R::load(z));
        let d = [R::load(&columns.d[k[0]]), R::load(&columns.d[k[1]]), R::load(&columns.d[k[2]])];
        let along = R::splat(1.0) / d[2];
        let reach = o.abs().max_element() + R::splat(LARGEST);
        let [sx, sy, sz] = [&columns.o[k[0]], &columns.o[k[1]], &columns.o[k[2]]];
        Self {
            live: R::Mask::first(columns.len),
            o,
            inverse: Vec3x::new(inverse(R::load(dx)), inverse(R::load(dy)), inverse(R::load(dz))),
            t_max: R::load(&columns.t_max),
            k,
            sheared: [PerRay(R::load(sx)), PerRay(R::load(sy)), PerRay(R::load(sz))],
            s: [PerRay(d[0] / d[2]), PerRay(d[1] / d[2])],
            along,
            doubt: reach * along.abs() * R::splat(DOUBT),
        }
    }

    /// The hits of all rays, except of those in [`Open::left`].
    #[inline(always)]
    pub fn traverse<'a, const ANY: bool>(
        &self,
        leaves: &'a [Leaf],
        columns: &Columns,
        open: &mut Open<'a>,
        corners: &mut Corners<R>,
    ) -> Hits {
        let mut best = Best::new(self.t_max);
        open.clear();
        for leaf in leaves {
            let waiting = if ANY { self.live & !best.found } else { self.live };
            let entered = self.enter(leaf.bounds, best.t) & waiting;
            if entered.any() && open.has_room(entered.bitmask()) {
                for (i, point) in leaf.points.iter().enumerate() {
                    corners.set(i, self.shear(point));
                }
                self.leaf::<ANY>(leaf, corners, entered, &mut best, open);
            }
        }
        let mut hits = best.hits();
        hits.settle::<ANY>(open, columns);
        hits
    }

    /// The rays that enter a box before `limit`.
    #[inline(always)]
    fn enter(&self, [x, upper_x, y, upper_y, z, upper_z]: [f32; 6], limit: R) -> R::Mask {
        let low = Vec3x::new(R::splat(x), R::splat(y), R::splat(z));
        let high = Vec3x::new(R::splat(upper_x), R::splat(upper_y), R::splat(upper_z));
        let (low, high) = ((low - self.o) * self.inverse, (high - self.o) * self.inverse);
        let entry = low.min(high).max_element().max(R::splat(0.0));
        entry.lt(low.max(high).min_element().min(limit) * R::splat(WIDEN))
    }

    /// A point in the sheared frame.
    #[inline(always)]
    fn shear(&self, point: &[f32; 3]) -> Corner<PerRay<R>> {
        let [x, y, z] = [point[self.k[0]], point[self.k[1]], point[self.k[2]]];
        corner([PerRay(R::splat(x)), PerRay(R::splat(y)), PerRay(R::splat(z))], self.sheared, self.s)
    }

    /// Tests the rays of `mask` against the triangles of a leaf. What f32 cannot decide is added to `open`. The results
    /// are too random for branches to be predicted.
    #[inline(always)]
    fn leaf<'a, const ANY: bool>(
        &self,
        leaf: &'a Leaf,
        corners: &Corners<R>,
        mask: R::Mask,
        best: &mut Best<R>,
        open: &mut Open<'a>,
    ) {
        for (slot, &[a, b, c]) in leaf.corners.iter().enumerate() {
            let crossed = Crossed::new([corners.get(a), corners.get(b), corners.get(c)]);
            let Some(crossed) = crossed else { continue };
            let unsure = crossed.unsure & mask;
            open.push(leaf, slot, unsure.bitmask());
            let t = crossed.distance(PerRay(self.along)).0;
            let mut hit = crossed.mask & mask & !unsure & R::splat(0.0).lt(t) & t.le(best.t);
            let near = hit & self.is_near_end(t, self.doubt);
            if near.any() {
                let o = [PerRay(self.o.x), PerRay(self.o.y), PerRay(self.o.z)];
                let doubt = doubt(&leaf.block, slot, o, PerRay(self.along));
                let near = near & self.is_near_end(t, doubt.0);
                open.push(leaf, slot, near.bitmask());
                hit = hit & !near;
            }
            best.take::<ANY>(hit, t, &crossed, leaf.id(slot));
        }
    }

    #[inline(always)]
    fn is_near_end(&self, t: R, doubt: R) -> R::Mask {
        is_near_end(PerRay(t), PerRay(self.t_max), PerRay(doubt))
    }

    /// The rays whose hit is so close to an end that the order of the tests may matter. The margin is larger than the
    /// difference between distances in f32 and f64.
    #[inline(always)]
    pub fn near_ends(&self, hits: &Hits) -> u32 {
        self.is_near_end(R::load(&hits.t), self.doubt + self.doubt).bitmask()
    }
}

/// 1/d, finite.
#[inline(always)]
fn inverse<R: Real>(d: R) -> R {
    (R::splat(1.0) / d).max(R::splat(-STEEPEST)).min(R::splat(STEEPEST))
}

/// The corners of a leaf in the sheared frame.
pub(super) struct Corners<R> {
    x: [R; Leaf::POINTS],
    y: [R; Leaf::POINTS],
    z: [R; Leaf::POINTS],
}

impl<R: Real> Corners<R> {
    #[inline(always)]
    pub fn new() -> Self {
        let zero = [R::splat(0.0); Leaf::POINTS];
        Self { x: zero, y: zero, z: zero }
    }

    #[inline(always)]
    fn set(&mut self, i: usize, (x, y, z): Corner<PerRay<R>>) {
        let i = i % Leaf::POINTS;
        (self.x[i], self.y[i], self.z[i]) = (x.0, y.0, z.0);
    }

    #[inline(always)]
    fn get(&self, i: u8) -> Corner<PerRay<R>> {
        let i = usize::from(i) % Leaf::POINTS;
        (PerRay(self.x[i]), PerRay(self.y[i]), PerRay(self.z[i]))
    }
}
