//! Records of the triangles of the flat tree: what their surfaces need and what does not depend on the hit, so that the
//! surfaces of many hits are computed at a time, over lanes, with the bits of [`Surface::on_triangle`](crate::Surface::on_triangle).

use super::objects::{Body, Object, Place};
use crate::barycentric::{shares, test_errors, weighted_sum};
use crate::smooth::{Rounded, Vector, is_unit, vector};
use crate::surface::{clear_from, facing, winding};
use dapple_math::lanes::{Double, Mask, Real, Vec3x, Word};
use dapple_math::vector::{unit_or, up};
use glam::{DVec3, Vec3};

/// Scenes with more triangles have no records: they take 64 bytes per triangle, as much as the tree, and 48 more per
/// triangle whose shading normal is interpolated.
const MOST: usize = 1 << 18;

/// In place of the first triangle of an object that has no records.
const NOT_FLAT: u32 = u32::MAX;

/// One record per triangle of the flat tree.
#[derive(Debug)]
pub struct Facets {
    /// Four rows per triangle: the corners, each with a component of the shading normal, and the geometric normal with
    /// the coordinate from which on points are clear of the edges. That is infinite where the surface is not known here.
    /// A shading normal of 0 is interpolated between those of the corners.
    rows: Vec<[f32; 4]>,
    /// The first triangle of each object.
    first: Vec<u32>,
    /// Three rows per triangle of the objects with shading normals: those of the corners.
    normals: Vec<[f32; 4]>,
    /// The first row of each object in `normals`.
    first_normal: Vec<u32>,
}

/// Surfaces of hits, one per lane.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<R: Real> {
    /// The lanes whose surface is known here; [`crate::Accel::surface`] gives those of the others.
    pub known: R::Mask,
    /// As [`Surface::p`](crate::Surface::p).
    pub p: Vec3x<R>,
    /// As [`Surface::start`](crate::Surface::start).
    pub start: Vec3x<R>,
    /// As [`Surface::p_error`](crate::Surface::p_error).
    pub p_error: Vec3x<R>,
    /// As [`Surface::ng`](crate::Surface::ng).
    pub ng: Vec3x<R>,
    /// As [`Surface::ns`](crate::Surface::ns).
    pub ns: Vec3x<R>,
    /// As [`Accel::lift`](crate::Accel::lift), on the side of the viewer.
    pub lift: Vec3x<R>,
}

impl Facets {
    /// The records of all objects in the flat tree, which has `triangles` triangles; none if these are too many.
    pub(super) fn new(objects: &[Object], triangles: usize) -> Self {
        let (mut first, mut first_normal) = (vec![NOT_FLAT; objects.len()], vec![0; objects.len()]);
        if triangles > MOST {
            return Self { rows: vec![], first, normals: vec![], first_normal };
        }
        let (mut rows, mut normals) = (Vec::with_capacity(4 * triangles), Vec::new());
        for ((object, first), first_normal) in objects.iter().zip(&mut first).zip(&mut first_normal) {
            if let (Body::Mesh(mesh), Place::World) = (&object.body, &object.place) {
                (*first, *first_normal) = (object.first, normals.len() as u32);
                for primitive in 0..mesh.triangles.len() as u32 {
                    let corner_normals = mesh.values(&mesh.normals, primitive);
                    rows.extend(record(mesh.corners(primitive), corner_normals));
                    normals.extend(corner_normals.into_iter().flatten().map(|n| n.extend(0.0).to_array()));
                }
            }
        }
        Self { rows, first, normals, first_normal }
    }

    /// The surfaces at the hits of a primitive of an object at (u, v), seen from the unit directions `wo`.
    #[inline(always)]
    pub fn surfaces<R: Real>(
        &self,
        (object, primitive): (R::Word, R::Word),
        (u, v): (R, R),
        wo: Vec3x<R>,
    ) -> Surfaces<R> {
        let first = R::Word::gather(&self.first, object);
        let row = first.wrapping_add(primitive) << 2;
        // Not by a closure: that would be compiled without the instruction set.
        let (one, two, three) = (R::Word::splat(1), R::Word::splat(2), R::Word::splat(3));
        let [ax, ay, az, nx] = R::gather_rows(&self.rows, row);
        let [bx, by, bz, ny] = R::gather_rows(&self.rows, row.wrapping_add(one));
        let [cx, cy, cz, nz] = R::gather_rows(&self.rows, row.wrapping_add(two));
        let [gx, gy, gz, clear] = R::gather_rows(&self.rows, row.wrapping_add(three));
        let shares = shares(R::Double::from_real(u), R::Double::from_real(v));
        let nearest = shares[0].to_real().min(u).min(v);
        let known = nearest.gt(clear) & first.ne(R::Word::splat(NOT_FLAT));
        let (x, y, z) = (axis([ax, bx, cx], shares), axis([ay, by, cy], shares), axis([az, bz, cz], shares));
        let p = Vec3x::new(x.0.to_real(), y.0.to_real(), z.0.to_real());
        let [ex, ey, ez] = test_errors([x.1, y.1, z.1], 7);
        let p_error = Vec3x::new(up(ex), up(ey), up(ez));
        // A point that is not moved is a sum with 0, which has no negative zeros.
        let (start, none) = (p + Vec3x::splat(Vec3::ZERO), Vec3x::splat(Vec3::ZERO));
        let (ng, ns) = (Vec3x::new(gx, gy, gz), Vec3x::new(nx, ny, nz));
        let flat = Surfaces { known, p, start, p_error, ng, ns, lift: none };
        let zero = R::splat(0.0);
        let varies = known & nx.eq(zero) & ny.eq(zero) & nz.eq(zero);
        if !varies.any() {
            return flat;
        }
        let row = R::Word::gather(&self.first_normal, object);
        let row = row.wrapping_add(primitive).wrapping_add(primitive << 1);
        let a = R::gather_rows(&self.normals, row);
        let b = R::gather_rows(&self.normals, row.wrapping_add(one));
        let c = R::gather_rows(&self.normals, row.wrapping_add(two));
        let rounded = Rounded {
            corners: [vector([ax, ay, az]), vector([bx, by, bz]), vector([cx, cy, cz])],
            normals: [vector([a[0], a[1], a[2]]), vector([b[0], b[1], b[2]]), vector([c[0], c[1], c[2]])],
            shares,
        };
        let interpolated = narrow::<R>(rounded.normal());
        let up = ng * R::splat(1.0).copysign(ng.dot(wo));
        let lift = narrow::<R>(rounded.lift(vector([up.x, up.y, up.z])));
        let is_given = varies & interpolated.is_finite();
        Surfaces {
            known: known & (is_given | !varies),
            ns: Vec3x::select(varies, interpolated, ns),
            lift: Vec3x::select(varies, lift, none),
            ..flat
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        let rows = size_of_val(&*self.rows) + size_of_val(&*self.normals);
        rows + size_of_val(&*self.first) + size_of_val(&*self.first_normal)
    }
}

/// One axis of a position and of its size.
#[inline(always)]
fn axis<R: Real>(x: [R; 3], shares: [R::Double; 3]) -> (R::Double, R::Double) {
    let [a, b, c] = x;
    weighted_sum([R::Double::from_real(a), R::Double::from_real(b), R::Double::from_real(c)], shares)
}

/// Rounds to f32.
#[inline(always)]
fn narrow<R: Real>([x, y, z]: Vector<R::Double>) -> Vec3x<R> {
    Vec3x::new(x.to_real(), y.to_real(), z.to_real())
}

/// The four rows of a triangle.
fn record(corners: [Vec3; 3], normals: Option<[Vec3; 3]>) -> [[f32; 4]; 4] {
    let winding = winding(corners);
    let ng = unit_or(winding, DVec3::Z);
    let ns = match normals {
        None => Some(ng.as_vec3()),
        Some(normals) => constant(normals, ng),
    };
    let is_known = ns.is_some() || normals.is_some_and(|normals| normals.into_iter().all(is_unit));
    let clear = if is_known { clear_from(corners) } else { f32::INFINITY };
    let (ns, [a, b, c]) = (ns.unwrap_or_default(), corners);
    let row = |v: Vec3, w| v.extend(w).to_array();
    [row(a, ns.x), row(b, ns.y), row(c, ns.z), row(ng.as_vec3(), clear)]
}

/// The shading normal of a triangle whose corners all have the same normal. `None` for others, and where the rounding of
/// the interpolation could change a bit.
fn constant([a, b, c]: [Vec3; 3], ng: DVec3) -> Option<Vec3> {
    /// More than the relative error of the sum and of its normalisation in f64.
    const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;
    let unit = unit_or(a.as_dvec3(), DVec3::ZERO);
    // The bits: zeros of both signs differ.
    let [a, b, c] = [a, b, c].map(|n| n.to_array().map(f32::to_bits));
    let is_one = a == b && b == c && unit != DVec3::ZERO;
    let has_side = unit.dot(ng).abs() > ROUNDING;
    let n = facing(unit, ng);
    let (less, more) = ((n * (1.0 - ROUNDING)).as_vec3(), (n * (1.0 + ROUNDING)).as_vec3());
    (is_one && has_side && less == more).then_some(n.as_vec3())
}
