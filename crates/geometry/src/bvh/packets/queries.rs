//! Queries of many rays: sorts them into packets, and traces these.

use super::columns::{Columns, ODD, sort};
use super::hits::{Hits, Open};
use super::packet::{Corners, Packet};
use crate::Rays;
use crate::bvh::hit_filter::TriangleHit;
use crate::bvh::traverse::in_callers_units;
use crate::bvh::tree::Tree;
use dapple_math::Ray;
use dapple_math::lanes::{Kernel, Real};

/// Packets that fill less than this part of the lanes are not worth while.
const FEWEST: usize = 4;

/// Queries for opaque triangles, in packets. With `ANY`, any hit will do, and only whether there is one is of use.
pub(in crate::bvh) struct Packets<'a, S, F, const ANY: bool> {
    pub tree: &'a Tree,
    pub rays: &'a Rays<'a>,
    /// Traces a single ray.
    pub single: S,
    /// Is called with the index and the hit of every ray.
    pub found: F,
}

impl<S, F, const ANY: bool> Kernel for Packets<'_, S, F, ANY>
where
    S: Fn(&Ray) -> Option<TriangleHit>,
    F: FnMut(usize, Option<TriangleHit>),
{
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(mut self) {
        let mut waiting = [const { Columns::EMPTY }; 4];
        let (mut open, mut corners) = (Open::new(), Corners::new());
        let (mut from, n) = (0, self.rays.len());
        while from < n {
            sort::<R>(self.tree, self.rays, from, &mut waiting);
            from += R::LANES;
            let least = if from < n { R::LANES } else { 1 };
            for (axis, columns) in waiting.iter_mut().enumerate() {
                while columns.len >= least {
                    self.trace::<R>(columns, axis, &mut open, &mut corners);
                    columns.drop_first::<R>();
                }
            }
        }
    }
}

impl<'a, S, F, const ANY: bool> Packets<'a, S, F, ANY>
where
    S: Fn(&Ray) -> Option<TriangleHit>,
    F: FnMut(usize, Option<TriangleHit>),
{
    /// Traces the first rays, one per lane. Few rays, and those that no packet can hold, are traced one by one.
    #[inline(always)]
    fn trace<R: Real>(
        &mut self,
        columns: &Columns,
        axis: usize,
        open: &mut Open<'a>,
        corners: &mut Corners<R>,
    ) {
        let len = columns.len.min(R::LANES);
        let (mut hits, mut again) = (Hits::NONE, u32::MAX);
        if axis != ODD && len * FEWEST >= R::LANES {
            let packet = Packet::<R>::new(columns, axis);
            hits = packet.traverse::<ANY>(&self.tree.leaves, columns, open, corners);
            again = open.left | if ANY { 0 } else { hits.found & packet.near_ends(&hits) };
        }
        for lane in 0..len {
            let i = columns.index[lane] as usize;
            let hit = if again >> lane & 1 == 1 {
                (self.single)(&self.rays.ray(i))
            } else if hits.found >> lane & 1 == 1 {
                Some(in_callers_units(hits.hit(lane), self.tree.unscale))
            } else {
                None
            };
            (self.found)(i, hit);
        }
    }
}
