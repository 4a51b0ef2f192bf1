//! The watertight ray–triangle test [Woop, Benthin, Wald 2013] over lanes: on eight triangles and one ray, or on one
//! triangle and several rays.
//!
//! The ray is sheared once so that it runs along an axis; the triangle is hit if its projection contains the origin of
//! the plane. Both triangles of an edge compute its edge function from the same two products. Rounding is monotone, so
//! they agree on the side unless the difference rounds to 0; then f64 decides, in which the products are exact. A point
//! on an edge belongs to both triangles, so that no ray passes between them. A fused multiply-add would break the
//! antisymmetry.
//!
//! The distance t is the mean of the corners' distances, weighted by the edge functions. Where that sum cancels (some
//! corners are behind the origin, as for a nearby large wall), and near either end of the ray, t is recomputed in f64.
//! A ray that starts or ends outside the error box of a surface therefore does not hit it there.

use super::hit_filter::TriangleHit;
use super::lanes::{Floats, Lanes, PerRay};
use super::node::Block;
use glam::{DVec3, Vec3A};

/// The line of a ray.
#[derive(Clone, Copy)]
pub(super) struct Line {
    pub o: [f32; 3],
    pub d: [f32; 3],
}

impl Line {
    /// The axes, of which the last is the one along which the ray advances most, and the shear that aligns the ray with
    /// that axis.
    #[inline(always)]
    fn shear(&self) -> ([usize; 3], [f32; 2]) {
        let [kx, ky, kz] = AXES[main_axis(self.d)];
        ([kx, ky, kz], [self.d[kx] / self.d[kz], self.d[ky] / self.d[kz]])
    }
}

/// The axes in the order in which a ray is sheared, by its main axis.
pub(super) const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The axis along which a ray advances most; the first one of several.
#[inline(always)]
fn main_axis(d: [f32; 3]) -> usize {
    let [x, y, z] = [d[0].abs(), d[1].abs(), d[2].abs()];
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// A ray and the shear that aligns it with axis `k[2]`.
#[derive(Clone, Copy)]
pub(super) struct Sheared {
    line: Line,
    k: [usize; 3],
    s: [f32; 3],
    /// Upper bound of the uncertainty of any distance to a triangle.
    doubt: f32,
}

impl Sheared {
    #[inline(always)]
    pub fn new(o: Vec3A, d: Vec3A, r: Vec3A) -> Self {
        let reach = o.abs().max_element() + LARGEST;
        let line = Line { o: o.to_array(), d: d.to_array() };
        let (k, [sx, sy]) = line.shear();
        let s = [sx, sy, r.to_array()[k[2]]];
        Self { line, k, s, doubt: reach * s[2].abs() * DOUBT }
    }
}

/// The coordinates of a tree are below this.
pub(super) const LARGEST: f32 = 2.0;

/// Hits closer to an end of the ray than this times the extent of the triangle are recomputed in f64.
pub(super) const DOUBT: f32 = 1.0 / 16384.0;

/// The results of the eight-wide test for lanes that may be hit.
pub(super) struct LaneHits {
    /// Candidate lanes.
    pub mask: u32,
    /// Candidate lanes that f32 cannot decide.
    unsure: u32,
    t: [f32; 8],
    v: [f32; 8],
    w: [f32; 8],
    det: [f32; 8],
}

/// The triangles whose projections contain the origin of the plane.
#[derive(Clone, Copy)]
pub(super) struct Crossed<F: Floats> {
    pub mask: F::Mask,
    /// Lanes of which f32 cannot decide whether or where they are hit.
    pub unsure: F::Mask,
    /// The edge functions of corner 1 and 2, and the sum of all three.
    pub v: F,
    pub w: F,
    pub det: F,
    /// The distances of the corners, weighted by the edge functions.
    pub sum: F,
}

/// A sum is not trusted in f32 if its terms are this many times larger than it, or if it is smaller than `TINY`.
const CANCELS: f32 = 3.0;
const TINY: f32 = 1e-27;

macro_rules! edges {
    ($a:ident, $b:ident, $c:ident) => {
        (
            $c.0.mul($b.1).sub($c.1.mul($b.0)),
            $a.0.mul($c.1).sub($a.1.mul($c.0)),
            $b.0.mul($a.1).sub($b.1.mul($a.0)),
        )
    };
}

impl<F: Floats> Crossed<F> {
    /// Tests triangles. None if no lane may be hit.
    #[inline(always)]
    pub fn new([a, b, c]: [Corner<F>; 3]) -> Option<Self> {
        let (u, v, w) = edges!(a, b, c);
        let zero = F::splat(0.0);
        let low = u.min(v.min(w));
        let high = u.max(v.max(w));
        let mask = F::either(zero.le(low), high.le(zero));
        if !F::any(mask) {
            return None;
        }
        let (ta, tb, tc) = (u.mul(a.2), v.mul(b.2), w.mul(c.2));
        let sum = ta.add(tb).add(tc);
        let terms = ta.abs().add(tb.abs()).add(tc.abs());
        let det = u.add(v).add(w);
        let on_edge = F::either(low.eq(zero), high.eq(zero));
        let cancels = sum.abs().mul(F::splat(CANCELS)).le(terms.add(F::splat(TINY)));
        let unsure = F::both(mask, F::either(on_edge, cancels));
        Some(Self { mask, unsure, v, w, det, sum })
    }

    /// The distance along the ray, with 1/d on its main axis.
    #[inline(always)]
    pub fn distance(&self, along: F) -> F {
        self.sum.div(self.det).mul(along)
    }
}

/// A corner in the sheared frame, with its unscaled distance.
pub(super) type Corner<F> = (F, F, F);

/// Shears a corner. All are in the order of the axes of the shear.
#[inline(always)]
pub(super) fn corner<F: Floats>(p: [F; 3], o: [F; 3], s: [F; 2]) -> Corner<F> {
    let z = p[2].sub(o[2]);
    (p[0].sub(o[0]).sub(s[0].mul(z)), p[1].sub(o[1]).sub(s[1].mul(z)), z)
}

/// Finds the lanes of `block` that are hit at 0 < t ≤ `limit`, and those that [`LaneHits::hit`] must decide.
#[inline(always)]
pub(super) fn intersect<L: Lanes>(ray: &Sheared, block: &Block, limit: f32) -> Option<LaneHits> {
    let [kx, ky, kz] = ray.k;
    let (x, y, z) = (&block.corner[kx], &block.corner[ky], &block.corner[kz]);
    let (o, s) = (ray.line.o, [L::splat(ray.s[0]), L::splat(ray.s[1])]);
    let o = [L::splat(o[kx]), L::splat(o[ky]), L::splat(o[kz])];
    let a = corner([L::load(&x[0]), L::load(&y[0]), L::load(&z[0])], o, s);
    let b = corner([L::load(&x[1]), L::load(&y[1]), L::load(&z[1])], o, s);
    let c = corner([L::load(&x[2]), L::load(&y[2]), L::load(&z[2])], o, s);
    let crossed = Crossed::new([a, b, c])?;
    let Crossed { mask, unsure, v, w, det, .. } = crossed;
    let t = crossed.distance(L::splat(ray.s[2]));
    let mask = mask & (unsure | (L::splat(0.0).lt(t) & t.le(L::splat(limit))));
    if mask == 0 {
        return None;
    }
    Some(LaneHits { mask, unsure, t: t.array(), v: v.array(), w: w.array(), det: det.array() })
}

impl LaneHits {
    /// The hit in `lane`, with t > 0; None if the f64 computation shows that there is none. Hits near either end of the
    /// ray are always recomputed in f64: otherwise a surface would shadow itself, and a light its own samples.
    #[inline(always)]
    pub fn hit(
        &self,
        ray: &Sheared,
        block: &Block,
        lane: usize,
        limit: f32,
        t_max: f32,
    ) -> Option<TriangleHit> {
        let t = self.t[lane];
        let [x, y, z] = ray.line.o;
        let o = [PerRay(x), PerRay(y), PerRay(z)];
        if self.unsure >> lane & 1 == 1
            || is_near_end(PerRay(t), PerRay(t_max), PerRay(ray.doubt))
                && is_near_end(PerRay(t), PerRay(t_max), doubt(block, lane, o, PerRay(ray.s[2])))
        {
            return decide(&ray.line, block, lane, limit);
        }
        let det = self.det[lane];
        Some(TriangleHit { t, u: self.v[lane] / det, v: self.w[lane] / det, triangle: block.id[lane] })
    }
}

/// Whether a hit is so close to an end of the ray that it is recomputed in f64.
#[inline(always)]
pub(super) fn is_near_end<F: Floats>(t: F, t_max: F, doubt: F) -> F::Mask {
    F::either(t.lt(doubt), t_max.sub(t).lt(doubt))
}

/// Bound of the uncertainty of the distance to one triangle, for rays with 1/d = `along` on their main axis. The largest
/// coordinate of the corners relative to the ray origin is decisive: the error of t is a few ulp of it.
#[inline(always)]
pub(super) fn doubt<F: Floats>(block: &Block, lane: usize, o: [F; 3], along: F) -> F {
    let mut reach = F::splat(0.0);
    for (corners, o) in block.corner.iter().zip(o) {
        for corner in corners {
            reach = reach.max(F::splat(corner[lane % 8]).sub(o).abs());
        }
    }
    reach.mul(along.abs()).mul(F::splat(DOUBT))
}

/// The hit on a triangle at 0 < t ≤ `limit`, computed in f64. The triangle is most often the one that the ray starts
/// from, or a wall behind the current hit, for which the barycentric coordinates are not needed.
#[inline(always)]
pub(super) fn decide(line: &Line, block: &Block, lane: usize, limit: f32) -> Option<TriangleHit> {
    let t = plane_distance(line, block, lane) as f32;
    if !(t > 0.0 && t <= limit) {
        return None;
    }
    let (u, v) = barycentrics(line, block, lane)?;
    Some(TriangleHit { t, u, v, triangle: block.id[lane] })
}

/// Distance along the ray to the plane of the triangle, in f64, in which the f32 corners are exact: an origin in an
/// axis-parallel plane is at a distance of exactly 0. NaN for a ray in the plane.
#[inline(always)]
fn plane_distance(line: &Line, block: &Block, lane: usize) -> f64 {
    let a = exact_corner(block, 0, lane);
    let n = (exact_corner(block, 1, lane) - a).cross(exact_corner(block, 2, lane) - a);
    n.dot(a - wide(line.o)) / n.dot(wide(line.d))
}

/// A corner of a triangle in f64.
#[inline(always)]
fn exact_corner(block: &Block, corner: usize, lane: usize) -> DVec3 {
    let [x, y, z] = &block.corner;
    wide([x[corner][lane], y[corner][lane], z[corner][lane]])
}

#[inline(always)]
fn wide([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into())
}

/// Barycentric coordinates (u, v) of the intersection with one triangle, in f64, from the same edge functions with
/// exact signs. None if the ray misses the triangle.
#[cold]
#[inline(never)]
fn barycentrics(line: &Line, block: &Block, lane: usize) -> Option<(f32, f32)> {
    let Line { o, d } = *line;
    let ([kx, ky, kz], s) = line.shear();
    let mut rounded = [[0.0f64; 2]; 3];
    let mut deep = [[0.0f64; 3]; 3];
    let (dx, dy) = (f64::from(d[kx]), f64::from(d[ky]));
    let dz = f64::from(d[kz]);
    let (sx, sy) = (dx / dz, dy / dz);
    for i in 0..3 {
        let (px, py, pz) = (block.corner[kx][i][lane], block.corner[ky][i][lane], block.corner[kz][i][lane]);
        let z = pz - o[kz];
        rounded[i] = [f64::from((px - o[kx]) - s[0] * z), f64::from((py - o[ky]) - s[1] * z)];
        let z = f64::from(pz) - f64::from(o[kz]);
        deep[i] =
            [(f64::from(px) - f64::from(o[kx])) - sx * z, (f64::from(py) - f64::from(o[ky])) - sy * z, z];
    }
    let signed = edge_functions(rounded[0], rounded[1], rounded[2]);
    let low = signed[0].min(signed[1]).min(signed[2]);
    let high = signed[0].max(signed[1]).max(signed[2]);
    let (inside, flat) = (low >= 0.0 || high <= 0.0, low == 0.0 && high == 0.0);
    if !inside || flat {
        return None;
    }
    // The signs above decide whether it is a hit; where f64 disagrees, the point moves to the nearest edge.
    let side = if high > 0.0 { 1.0 } else { -1.0 };
    let xy = |i: usize| [deep[i][0], deep[i][1]];
    let mut weights = edge_functions(xy(0), xy(1), xy(2)).map(|w| (w * side).max(0.0));
    let mut sum = weights[0] + weights[1] + weights[2];
    if sum == 0.0 {
        weights = signed.map(|w| w * side);
        sum = weights[0] + weights[1] + weights[2];
    }
    Some(((weights[1] / sum) as f32, (weights[2] / sum) as f32))
}

fn edge_functions(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> [f64; 3] {
    [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]]
}
