//! The watertight ray–triangle test [Woop, Benthin, Wald 2013], eight triangles at a time.
//!
//! The ray is sheared once so that it runs along an axis; edge functions are products of the same two numbers for both
//! triangles of an edge, so exactly one side (or both) accepts. An edge function of exactly 0 is decided again in f64,
//! where the products are exact. No fused multiply-add: it would break the antisymmetry.

use super::TriangleHit;
use super::node::Block;
use super::simd::Lanes;
use crate::Ray;
use glam::{DVec3, Vec3};

/// A ray, sheared to run along axis `k[2]`.
#[derive(Clone, Copy)]
pub(super) struct Sheared {
    pub o: Vec3,
    pub d: Vec3,
    k: [usize; 3],
    s: [f32; 3],
}

impl Sheared {
    pub fn new(ray: &Ray) -> Self {
        let a = ray.d.abs();
        let kz = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let d = ray.d;
        Self { o: ray.o, d, k: [kx, ky, kz], s: [d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]] }
    }
}

/// Edge functions and distance of the lanes that may be hit.
pub(super) struct Found {
    u: [f32; 8],
    v: [f32; 8],
    w: [f32; 8],
    t: [f32; 8],
    /// Lanes with 0 < t ≤ limit whose edges all agree.
    pub mask: u32,
}

/// Tests a block; `limit` is inclusive, for ties are decided by id.
#[inline(always)]
pub(super) fn intersect<L: Lanes>(ray: &Sheared, block: &Block, limit: f32) -> Found {
    let [kx, ky, kz] = ray.k;
    let o = [L::splat(ray.o[kx]), L::splat(ray.o[ky]), L::splat(ray.o[kz])];
    let (sx, sy, sz) = (L::splat(ray.s[0]), L::splat(ray.s[1]), L::splat(ray.s[2]));
    let (ax, ay, az) = shear(&block.corner[0], ray.k, o, sx, sy);
    let (bx, by, bz) = shear(&block.corner[1], ray.k, o, sx, sy);
    let (cx, cy, cz) = shear(&block.corner[2], ray.k, o, sx, sy);
    let u = cx.mul(by).sub(cy.mul(bx));
    let v = ax.mul(cy).sub(ay.mul(cx));
    let w = bx.mul(ay).sub(by.mul(ax));
    let zero = L::splat(0.0);
    let negative = u.lt(zero) | v.lt(zero) | w.lt(zero);
    let positive = zero.lt(u) | zero.lt(v) | zero.lt(w);
    let on_edge = u.eq(zero) | v.eq(zero) | w.eq(zero);
    let det = u.add(v).add(w);
    let t = u.mul(az).add(v.mul(bz)).add(w.mul(cz)).mul(sz).div(det);
    let in_range = zero.lt(t) & t.le(L::splat(limit));
    let mut found = Found { u: [0.0; 8], v: [0.0; 8], w: [0.0; 8], t: [0.0; 8], mask: 0 };
    let candidates = !(negative & positive) & !on_edge & in_range;
    if (candidates | on_edge) & 0xff == 0 {
        return found;
    }
    u.store(&mut found.u);
    v.store(&mut found.v);
    w.store(&mut found.w);
    t.store(&mut found.t);
    found.mask = candidates & 0xff;
    if on_edge & 0xff != 0 {
        exact_edges(ray, block, on_edge & 0xff, limit, &mut found);
    }
    found
}

/// Corners relative to the origin, sheared so that the ray runs along z. (A function and not a closure: only what is
/// always inlined is compiled for the caller's instruction set.)
#[inline(always)]
fn shear<L: Lanes>(corner: &[[f32; 8]; 3], [kx, ky, kz]: [usize; 3], o: [L; 3], sx: L, sy: L) -> (L, L, L) {
    let z = L::load(&corner[kz]).sub(o[2]);
    let x = L::load(&corner[kx]).sub(o[0]).sub(sx.mul(z));
    let y = L::load(&corner[ky]).sub(o[1]).sub(sy.mul(z));
    (x, y, z)
}

/// Decides the lanes of `mask` again with exact edge functions.
#[cold]
#[inline(never)]
fn exact_edges(ray: &Sheared, block: &Block, mask: u32, limit: f32, found: &mut Found) {
    let [kx, ky, kz] = ray.k;
    for lane in (0..8).filter(|lane| mask >> lane & 1 == 1) {
        let corner = |c: usize| {
            let z = block.corner[c][kz][lane] - ray.o[kz];
            let x = (block.corner[c][kx][lane] - ray.o[kx]) - ray.s[0] * z;
            let y = (block.corner[c][ky][lane] - ray.o[ky]) - ray.s[1] * z;
            (f64::from(x), f64::from(y), f64::from(z))
        };
        let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (corner(0), corner(1), corner(2));
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let mixed = (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0);
        let det = u + v + w;
        let t = ((u * az + v * bz + w * cz) * f64::from(ray.s[2]) / det) as f32;
        if !mixed && t > 0.0 && t <= limit {
            // The edge functions are kept as barycentrics: in f32 they may have lost all digits.
            found.u[lane] = (u / det) as f32;
            found.v[lane] = (v / det) as f32;
            found.w[lane] = (w / det) as f32;
            found.t[lane] = t;
            found.mask |= 1 << lane;
        }
    }
}

impl Found {
    /// The hit in `lane`; None when a closer look at a very near one shows it behind the origin.
    #[inline(always)]
    pub fn hit(&self, ray: &Sheared, block: &Block, lane: usize) -> Option<TriangleHit> {
        let (u, v, w, mut t) = (self.u[lane], self.v[lane], self.w[lane], self.t[lane]);
        let det = u + v + w;
        if self.is_near(ray, block, lane) {
            t = plane_distance(ray, block, lane)?;
        }
        Some(TriangleHit { t, u: v / det, v: w / det, triangle: block.id[lane] })
    }

    /// Whether rounding could have put the hit on the wrong side of the origin: the error of t is a few ulp of the
    /// corners' distance along the ray.
    #[inline(always)]
    fn is_near(&self, ray: &Sheared, block: &Block, lane: usize) -> bool {
        let [kx, ky, kz] = ray.k;
        let reach = |c: usize| {
            let at = |k: usize| (block.corner[c][k][lane] - ray.o[k]).abs();
            at(kx).max(at(ky)).max(at(kz))
        };
        self.t[lane] < reach(0).max(reach(1)).max(reach(2)) * ray.s[2].abs() * (1.0 / 16384.0)
    }
}

/// Distance along the ray to the triangle's plane, in f64 where the f32 corners are exact; None at or behind the
/// origin.
#[cold]
#[inline(never)]
fn plane_distance(ray: &Sheared, block: &Block, lane: usize) -> Option<f32> {
    let corner =
        |c: usize| DVec3::from_array(std::array::from_fn(|axis| f64::from(block.corner[c][axis][lane])));
    let a = corner(0);
    let n = (corner(1) - a).cross(corner(2) - a);
    let t = (n.dot(a - ray.o.as_dvec3()) / n.dot(ray.d.as_dvec3())) as f32;
    (t > 0.0).then_some(t)
}
