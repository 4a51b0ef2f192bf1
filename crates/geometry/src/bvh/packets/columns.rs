//! Rays that wait for a packet to be full, in columns.

use crate::Rays;
use crate::bvh::query::LONG;
use crate::bvh::tree::Tree;
use crate::bvh::triangle::Line;
use dapple_math::lanes::{MAX_LANES, Mask, Real, Vec3x, Word};

/// Place of the rays that no packet can hold, after those of the three axes: rays that
/// [`Query::new`](crate::bvh::query::Query::new) does not accept.
pub(super) const ODD: usize = 3;

/// A number of every ray of a packet, and of as many more.
type Column = [f32; 2 * MAX_LANES];

/// Rays in the tree's units. At most one packet waits for being filled by another one.
pub(super) struct Columns {
    pub len: usize,
    pub index: [u32; 2 * MAX_LANES],
    pub o: [Column; 3],
    pub d: [Column; 3],
    pub t_max: Column,
}

impl Columns {
    pub const EMPTY: Self = {
        let (zero, zeros) = ([0.0; 2 * MAX_LANES], [[0.0; 2 * MAX_LANES]; 3]);
        Self { len: 0, index: [0; 2 * MAX_LANES], o: zeros, d: zeros, t_max: zero }
    };

    /// Adds the lanes of `mask`, of which the first is ray `from`.
    #[inline(always)]
    fn push<R: Real>(&mut self, mask: R::Mask, from: usize, (o, d, t_max): (Vec3x<R>, Vec3x<R>, R)) {
        let at = self.len % MAX_LANES;
        let index = R::Word::lane_index().wrapping_add(R::Word::splat(from as u32));
        self.len = at + index.compress_store(mask, &mut self.index[at..]);
        let [x, y, z] = &mut self.o;
        o.compress_store(mask, [&mut x[at..], &mut y[at..], &mut z[at..]]);
        let [x, y, z] = &mut self.d;
        d.compress_store(mask, [&mut x[at..], &mut y[at..], &mut z[at..]]);
        t_max.compress_store(mask, &mut self.t_max[at..]);
    }

    /// Removes the first rays, one per lane.
    #[inline(always)]
    pub fn drop_first<R: Real>(&mut self) {
        self.len = self.len.saturating_sub(R::LANES);
        if self.len > 0 {
            let [x, y, z] = &mut self.o;
            let [dx, dy, dz] = &mut self.d;
            for column in [x, y, z, dx, dy, dz, &mut self.t_max] {
                R::load(&column[R::LANES..]).store(&mut column[..R::LANES]);
            }
            R::Word::load(&self.index[R::LANES..]).store(&mut self.index[..R::LANES]);
        }
    }

    /// The line of one ray.
    #[inline(always)]
    pub fn line(&self, lane: usize) -> Line {
        let ([x, y, z], [dx, dy, dz]) = (&self.o, &self.d);
        Line { o: [x[lane], y[lane], z[lane]], d: [dx[lane], dy[lane], dz[lane]] }
    }
}

/// Adds rays from `from` on, one per lane, to the columns of their main axes.
#[inline(always)]
pub(super) fn sort<R: Real>(tree: &Tree, rays: &Rays, from: usize, waiting: &mut [Columns; 4]) {
    let [x, y, z] = rays.o();
    let o = Vec3x::<R>::load([&x[from..], &y[from..], &z[from..]]) * R::splat(tree.scale);
    let [x, y, z] = rays.d();
    let d = Vec3x::<R>::load([&x[from..], &y[from..], &z[from..]]);
    let t_max = match rays.t_max() {
        None => R::splat(f32::INFINITY),
        Some(t_max) => R::load(&t_max[from..]),
    };
    let all = R::Mask::first(rays.len() - from);
    let good = all & is_plain(o, d, t_max);
    let size = d.abs();
    let along_x = size.y.le(size.x) & size.z.le(size.x);
    let along_y = !along_x & size.z.le(size.y);
    let columns = (o, d, t_max * R::splat(tree.scale));
    waiting[0].push(good & along_x, from, columns);
    waiting[1].push(good & along_y, from, columns);
    waiting[2].push(good & !along_x & !along_y, from, columns);
    let odd = all & !good;
    if odd.any() {
        waiting[ODD].push(odd, from, columns);
    }
}

/// Whether [`Query::new`](crate::bvh::query::Query::new) accepts a ray.
#[inline(always)]
fn is_plain<R: Real>(o: Vec3x<R>, d: Vec3x<R>, t_max: R) -> R::Mask {
    let long = d.abs().max_element();
    let in_range = long.lt(R::splat(LONG)) & long.gt(R::splat(1.0 / LONG));
    in_range & d.is_finite() & o.is_finite() & R::splat(0.0).lt(t_max)
}
