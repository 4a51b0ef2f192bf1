//! The watertight ray–triangle test [Woop, Benthin, Wald 2013] on eight triangles at a time.
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
use super::lanes::Lanes;
use super::node::Block;
use glam::{DVec3, Vec3A};

/// A ray and the shear that aligns it with axis `k[2]`.
#[derive(Clone, Copy)]
pub(super) struct Sheared {
    pub o: [f32; 3],
    pub d: [f32; 3],
    k: [usize; 3],
    s: [f32; 3],
    /// Upper bound of the uncertainty of any distance to a triangle.
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

/// A sum is not trusted in f32 if its terms are this many times larger than it, or if it is smaller than `TINY`.
const CANCELS: f32 = 3.0;
const TINY: f32 = 1e-27;
/// Hits closer to an end of the ray than this times the extent of the triangle are recomputed in f64.
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

/// Finds the lanes of `block` that are hit at 0 < t ≤ `limit`, and those that [`LaneHits::hit`] must decide.
#[inline(always)]
pub(super) fn intersect<L: Lanes>(ray: &Sheared, block: &Block, limit: f32) -> Option<LaneHits> {
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
    if mask == 0 {
        return None;
    }
    Some(LaneHits { mask, unsure, t: t.array(), v: v.array(), w: w.array(), det: det.array() })
}

/// The corners in the sheared frame, with unscaled distances.
#[inline(always)]
fn corner<L: Lanes>(ray: &Sheared, x: &[f32; 8], y: &[f32; 8], z: &[f32; 8]) -> (L, L, L) {
    let z = L::load(z).sub(L::splat(ray.o[ray.k[2]]));
    let x = L::load(x).sub(L::splat(ray.o[ray.k[0]])).sub(L::splat(ray.s[0]).mul(z));
    let y = L::load(y).sub(L::splat(ray.o[ray.k[1]])).sub(L::splat(ray.s[1]).mul(z));
    (x, y, z)
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
        let triangle = block.id[lane];
        let t = self.t[lane];
        let in_doubt = |doubt: f32| t < doubt || t_max - t < doubt;
        if self.unsure >> lane & 1 == 1
            || in_doubt(ray.doubt) && in_doubt(reach(ray, block, lane) * ray.s[2].abs() * DOUBT)
        {
            // This is most often the triangle that the ray starts from, or a wall behind the current hit, for which the
            // barycentric coordinates are not needed.
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

/// Largest coordinate of the corners relative to the ray origin; the error of t is a few ulp of it.
#[inline(always)]
fn reach(ray: &Sheared, block: &Block, lane: usize) -> f32 {
    let mut most = 0.0f32;
    for (corners, o) in block.corner.iter().zip(ray.o) {
        for corner in corners {
            most = most.max((corner[lane] - o).abs());
        }
    }
    most
}

/// Distance along the ray to the plane of the triangle, in f64, in which the f32 corners are exact: an origin in an
/// axis-parallel plane is at a distance of exactly 0. NaN for a ray in the plane.
#[inline(always)]
fn plane_distance(ray: &Sheared, block: &Block, lane: usize) -> f64 {
    let a = exact_corner(block, 0, lane);
    let n = (exact_corner(block, 1, lane) - a).cross(exact_corner(block, 2, lane) - a);
    n.dot(a - wide(ray.o)) / n.dot(wide(ray.d))
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
