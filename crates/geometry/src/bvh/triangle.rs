//! The watertight ray–triangle test [Woop, Benthin, Wald 2013], eight triangles at a time.
//!
//! The ray is sheared once so that it runs along an axis; then the triangle is hit if the origin of the plane lies in
//! its projection. Both triangles of an edge compute the edge function from the same two products, rounding is
//! monotone, and so they agree about the side unless the difference rounds to 0; then f64, where the products are
//! exact, decides. A point on an edge belongs to both triangles: no ray passes between. A fused multiply-add would
//! break the antisymmetry.
//!
//! t is the mean of the corners' distances, weighted by the edge functions. Where that cancels (some corners lie
//! behind the origin, as for a large wall near by), and near either end of the ray, it is worked out again in f64, so
//! that it can be relied on: a ray that starts or ends outside the error box of a surface does not meet it there.

use super::hit_filter::TriangleHit;
use super::lanes::Lanes;
use super::node::Block;
use glam::{DVec3, Vec3A};

/// A ray and the shear that makes it run along axis `k[2]`.
#[derive(Clone, Copy)]
pub(super) struct Sheared {
    pub o: [f32; 3],
    pub d: [f32; 3],
    k: [usize; 3],
    s: [f32; 3],
    /// No distance to a triangle is in doubt by more than this.
    doubt: f32,
}

impl Sheared {
    #[inline(always)]
    pub fn new(o: Vec3A, d: Vec3A, r: Vec3A) -> Self {
        let [x, y, z] = d.abs().to_array();
        let k = if x >= y && x >= z {
            [1, 2, 0]
        } else if y >= z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        // The coordinates of a tree are below 2.
        let reach = o.abs().max_element() + 2.0;
        let (o, d, r) = (o.to_array(), d.to_array(), r.to_array());
        let s = r[k[2]];
        Self { o, d, k, s: [d[k[0]] / d[k[2]], d[k[1]] / d[k[2]], s], doubt: reach * s.abs() * DOUBT }
    }
}

/// What the eight-wide test knows of the lanes that may be hit.
pub(super) struct Found {
    /// Lanes to look at.
    pub mask: u32,
    /// Of these, the ones that f32 cannot decide.
    unsure: u32,
    t: [f32; 8],
    v: [f32; 8],
    w: [f32; 8],
    det: [f32; 8],
}

/// A sum whose terms are this many times larger than itself, or this small, is not trusted in f32.
const CANCELS: f32 = 3.0;
const TINY: f32 = 1e-27;
/// Hits nearer to an end of the ray than this times the reach of the triangle are looked at in f64.
const DOUBT: f32 = 1.0 / 16384.0;

macro_rules! edges {
    ($a:ident, $b:ident, $c:ident) => {
        (
            $c.0.mul($b.1).sub($c.1.mul($b.0)),
            $a.0.mul($c.1).sub($a.1.mul($c.0)),
            $b.0.mul($a.1).sub($b.1.mul($a.0)),
        )
    };
}

/// The lanes of `block` hit at 0 < t ≤ `limit`, and those that [`Found::hit`] must decide.
#[inline(always)]
pub(super) fn intersect<L: Lanes>(ray: &Sheared, block: &Block, limit: f32) -> Option<Found> {
    let [kx, ky, kz] = ray.k;
    let a = corner::<L>(ray, &block.corner[kx][0], &block.corner[ky][0], &block.corner[kz][0]);
    let b = corner::<L>(ray, &block.corner[kx][1], &block.corner[ky][1], &block.corner[kz][1]);
    let c = corner::<L>(ray, &block.corner[kx][2], &block.corner[ky][2], &block.corner[kz][2]);
    let (u, v, w) = edges!(a, b, c);
    let zero = L::splat(0.0);
    let low = u.min(v.min(w));
    let high = u.max(v.max(w));
    let mask = zero.le(low) | high.le(zero);
    if mask == 0 {
        return None;
    }
    let (ta, tb, tc) = (u.mul(a.2), v.mul(b.2), w.mul(c.2));
    let sum = ta.add(tb).add(tc);
    let terms = ta.abs().add(tb.abs()).add(tc.abs());
    let det = u.add(v).add(w);
    let t = sum.div(det).mul(L::splat(ray.s[2]));
    let on_edge = (zero.le(low) & low.le(zero)) | (zero.le(high) & high.le(zero));
    let cancels = sum.abs().mul(L::splat(CANCELS)).le(terms.add(L::splat(TINY)));
    let unsure = mask & (on_edge | cancels);
    let mask = mask & (unsure | (zero.lt(t) & t.le(L::splat(limit))));
    (mask != 0).then(|| Found { mask, unsure, t: t.array(), v: v.array(), w: w.array(), det: det.array() })
}

/// Corners in the sheared frame, their distances not yet scaled.
#[inline(always)]
fn corner<L: Lanes>(ray: &Sheared, x: &[f32; 8], y: &[f32; 8], z: &[f32; 8]) -> (L, L, L) {
    let z = L::load(z).sub(L::splat(ray.o[ray.k[2]]));
    let x = L::load(x).sub(L::splat(ray.o[ray.k[0]])).sub(L::splat(ray.s[0]).mul(z));
    let y = L::load(y).sub(L::splat(ray.o[ray.k[1]])).sub(L::splat(ray.s[1]).mul(z));
    (x, y, z)
}

impl Found {
    /// The hit in `lane`, with t > 0; None if a closer look shows that there is none. Hits near either end of the ray
    /// get that look: without it a surface would shadow itself, and a light its own samples.
    #[inline(always)]
    pub fn hit(
        &self,
        ray: &Sheared,
        block: &Block,
        lane: usize,
        limit: f32,
        t_max: f32,
    ) -> Option<TriangleHit> {
        let triangle = block.id[lane];
        let t = self.t[lane];
        let in_doubt = |doubt: f32| t < doubt || t_max - t < doubt;
        if self.unsure >> lane & 1 == 1
            || in_doubt(ray.doubt) && in_doubt(reach(ray, block, lane) * ray.s[2].abs() * DOUBT)
        {
            // Most often the triangle that the ray starts from, or a wall behind what it hits: no need to know where it
            // is passed.
            let t = plane_distance(ray, block, lane) as f32;
            if !(t > 0.0 && t <= limit) {
                return None;
            }
            return barycentrics(ray, block, lane).map(|(u, v)| TriangleHit { t, u, v, triangle });
        }
        let det = self.det[lane];
        Some(TriangleHit { t, u: self.v[lane] / det, v: self.w[lane] / det, triangle })
    }
}

/// Largest coordinate of the corners seen from the origin: t is wrong by a few ulp of it.
#[inline(always)]
fn reach(ray: &Sheared, block: &Block, lane: usize) -> f32 {
    let along = |k: usize| {
        let at = |c: usize| (block.corner[k][c][lane] - ray.o[k]).abs();
        at(0).max(at(1)).max(at(2))
    };
    along(0).max(along(1)).max(along(2))
}

/// Distance along the ray to the triangle's plane, in f64 where the f32 corners are exact: an origin in an axis-parallel
/// plane is at exactly 0. NaN for a ray in the plane.
#[inline(always)]
fn plane_distance(ray: &Sheared, block: &Block, lane: usize) -> f64 {
    let corner = |c: usize| DVec3::from_array(std::array::from_fn(|k| f64::from(block.corner[k][c][lane])));
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let a = corner(0);
    let n = (corner(1) - a).cross(corner(2) - a);
    n.dot(a - wide(ray.o)) / n.dot(wide(ray.d))
}

/// (u, v) where a ray passes one triangle, in f64: the same edge functions, their signs exact. None if it does not.
#[cold]
#[inline(never)]
fn barycentrics(ray: &Sheared, block: &Block, lane: usize) -> Option<(f32, f32)> {
    let [kx, ky, kz] = ray.k;
    let mut rounded = [[0.0f64; 2]; 3];
    let mut deep = [[0.0f64; 3]; 3];
    let (dx, dy) = (f64::from(ray.d[kx]), f64::from(ray.d[ky]));
    let dz = f64::from(ray.d[kz]);
    let (sx, sy) = (dx / dz, dy / dz);
    for i in 0..3 {
        let (px, py, pz) = (block.corner[kx][i][lane], block.corner[ky][i][lane], block.corner[kz][i][lane]);
        let z = pz - ray.o[kz];
        rounded[i] = [f64::from((px - ray.o[kx]) - ray.s[0] * z), f64::from((py - ray.o[ky]) - ray.s[1] * z)];
        let z = f64::from(pz) - f64::from(ray.o[kz]);
        deep[i] = [
            (f64::from(px) - f64::from(ray.o[kx])) - sx * z,
            (f64::from(py) - f64::from(ray.o[ky])) - sy * z,
            z,
        ];
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
