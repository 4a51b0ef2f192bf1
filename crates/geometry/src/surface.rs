//! The surface at a hit: position with error bound, geometric and shading normal.
//!
//! A position is never computed as `o + t·d`. It is reconstructed from the surface, so that its error does not grow
//! with the length or the grazing angle of the ray.
use crate::barycentric::{MIXED, shares, test_error, weighted};
use crate::smooth::{Rounded, is_unit};
use dapple_math::Ray;
use dapple_math::motion::Pose;
use dapple_math::offset::{UNIT_ROUNDOFF, gamma, offset_origin};
use dapple_math::vector::{round_up, unit_or};
use glam::{DVec3, Vec3};

/// Position and normals of a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Position in render space.
    pub p: Vec3,
    /// Origin for rays that leave the surface: the position, moved away from the edges of its triangle where other
    /// geometry is adjacent ([`crate::Accel::surface`]).
    pub start: Vec3,
    /// Bound of |computed − exact| per axis.
    pub p_error: Vec3,
    /// Unit geometric normal of the front side (triangle: counter-clockwise winding; sphere: outward; disk: its
    /// normal).
    pub ng: Vec3,
    /// Unit shading normal, in the hemisphere of `ng`; equal to `ng` on flat geometry.
    pub ns: Vec3,
}

impl Surface {
    /// Origin of a ray from this point in direction `d`: see [`offset_origin`].
    pub fn origin_towards(&self, d: Vec3) -> Vec3 {
        offset_origin(self.start, self.p_error, self.ng, d)
    }

    /// The ray to another surface point. It starts and ends outside the error boxes of the two points, so that neither
    /// surface occludes it; the length of its direction is the distance between its ends.
    pub fn ray_to(&self, to: &Self) -> Ray {
        let way = to.start - self.start;
        let (o, target) = (self.origin_towards(way), to.origin_towards(-way));
        Ray { o, d: target - o, t_max: 1.0 - 16.0 * UNIT_ROUNDOFF }
    }

    /// Whether shading and geometric normal differ by more than the rounding of interpolated f32 normals.
    pub fn is_smooth(&self) -> bool {
        self.ns != self.ng && (self.ns - self.ng).abs().max_element() > gamma(8)
    }

    /// The point with barycentric coordinates (u, v) of a triangle: p = Σ bᵢpᵢ, summed in f64 and rounded once. The
    /// bound γ₇ Σ|bᵢpᵢ| [Pharr, Jakob & Humphreys 2023, §6.8.4] is wider than that rounding: it also covers the error
    /// of the intersection test for nearby ray origins, and it is never zero for a triangle that has an extent. `ng` is
    /// the f64 cross product of two edges; `ns` interpolates `normals`.
    #[inline(always)]
    pub fn on_triangle(corners: [Vec3; 3], normals: Option<[Vec3; 3]>, u: f32, v: f32) -> Self {
        let (p, size) = weighted(corners, u, v);
        let winding = winding(corners);
        let ng = unit_or(winding, DVec3::Z);
        let ns = normals.map_or(ng, |n| interpolated(corners, n, (u, v), ng));
        let error = test_error(size, 7);
        let start = p + clear_of_edges(corners.map(|c| c.as_dvec3()), winding, u, v, error);
        Self {
            p: p.as_vec3(),
            start: start.as_vec3(),
            p_error: round_up(error),
            ng: ng.as_vec3(),
            ns: ns.as_vec3(),
        }
    }

    /// As [`Surface::on_triangle`], for a triangle in object space. A ray is transformed to object space and rounded,
    /// so the bound is |M| times an object-space bound (with one rounding more than above) plus the rounding of `p`.
    pub(crate) fn on_posed_triangle(
        pose: &Pose,
        corners: [Vec3; 3],
        normals: Option<[Vec3; 3]>,
        u: f32,
        v: f32,
    ) -> Self {
        let (local, size) = weighted(corners, u, v);
        let map = pose.normals();
        let ng = unit_or(map.apply(winding(corners)), DVec3::Z);
        // Transforms each vertex normal, as if the mesh had been transformed.
        let turned = |n: Vec3| map.apply(n.as_dvec3()).as_vec3();
        let ns = normals.map_or(ng, |n| facing(unit_or(weighted(n.map(turned), u, v).0, ng), ng));
        let mut surface = Self::posed(pose, local, test_error(size, 8), ng, ns);
        let placed = corners.map(|c| pose.to_world.transform_point3(c.as_dvec3()));
        // The position and error bound that the flattened mesh would have.
        let p = pose.to_world.transform_point3(local);
        let error = pose.error(test_error(size, 7)).max(p.abs() * f64::from(gamma(7)));
        surface.start = (p + clear_of_edges(placed, cross(placed), u, v, error)).as_vec3();
        surface
    }

    /// A point of an exact shape. `local` is accurate to f64, so that only the rounding to f32 remains: γ₂|p|.
    pub(crate) fn on_shape(p: DVec3, n: DVec3) -> Self {
        let ng = n.as_vec3();
        let p_error = round_up(p.abs() * f64::from(gamma(2)));
        Self { p: p.as_vec3(), start: p.as_vec3(), p_error, ng, ns: ng }
    }

    /// As [`Surface::on_shape`], for a shape in object space.
    pub(crate) fn on_posed_shape(pose: &Pose, local: DVec3, n: DVec3) -> Self {
        let n = unit_or(pose.normals().apply(n), DVec3::Z);
        Self::posed(pose, local, local.abs() * f64::from(gamma(2)), n, n)
    }

    fn posed(pose: &Pose, local: DVec3, local_error: DVec3, ng: DVec3, ns: DVec3) -> Self {
        let p = pose.to_world.transform_point3(local);
        let error = pose.error(local_error) + p.abs() * f64::from(gamma(2));
        // The same amount on all axes: a transform that flattens or mixes the axes leaves none of them exact.
        let reach = pose.error(DVec3::splat(local.abs().max_element())) + pose.to_world.translation.abs();
        let error = error + DVec3::splat(reach.max_element() * MIXED);
        let at = p.as_vec3();
        Self { p: at, start: at, p_error: round_up(error), ng: ng.as_vec3(), ns: ns.as_vec3() }
    }
}

/// The position with barycentric coordinates (1 − u − v, u, v) and its error bound γ₇ Σ|bᵢpᵢ|; see
/// [`Surface::on_triangle`].
pub fn interpolate(corners: &[Vec3; 3], u: f32, v: f32) -> (Vec3, Vec3) {
    let (p, size) = weighted(*corners, u, v);
    (p.as_vec3(), round_up(test_error(size, 7)))
}

/// Unit normal of the counter-clockwise side, from f64 edges; zero for a triangle without area.
pub fn geometric_normal(corners: &[Vec3; 3]) -> Vec3 {
    unit_or(winding(*corners), DVec3::ZERO).as_vec3()
}

/// [`Rounded::lift`] of the facet at barycentric coordinates (u, v), for normals of any length.
pub(crate) fn lift(corners: [DVec3; 3], normals: [DVec3; 3], u: f32, v: f32, up: DVec3) -> DVec3 {
    let unit = |n: DVec3| if is_unit(n.as_vec3()) { n } else { unit_or(n, DVec3::ZERO) };
    let rounded = Rounded {
        corners: corners.map(|c| c.to_array()),
        normals: normals.map(|n| unit(n).to_array()),
        shares: shares(f64::from(u), f64::from(v)),
    };
    DVec3::from_array(rounded.lift(up.to_array()))
}

/// The unit normal interpolated between those of the corners of a triangle, in the hemisphere of its normal `ng`, which
/// it is where the normals cancel.
fn interpolated(corners: [Vec3; 3], normals: [Vec3; 3], (u, v): (f32, f32), ng: DVec3) -> DVec3 {
    if !normals.into_iter().all(is_unit) {
        return facing(unit_or(weighted(normals, u, v).0, ng), ng);
    }
    let wide = |v: [Vec3; 3]| v.map(|v| v.as_dvec3().to_array());
    let shares = shares(f64::from(u), f64::from(v));
    let rounded = Rounded { corners: wide(corners), normals: wide(normals), shares };
    let n = DVec3::from_array(rounded.normal());
    if n.is_finite() { n } else { ng }
}

/// Cross product of two edges: along the normal of the counter-clockwise side.
pub(crate) fn winding(corners: [Vec3; 3]) -> DVec3 {
    cross(corners.map(|c| c.as_dvec3()))
}

fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Minimum distance of a ray origin from the edges of its triangle, in units of its error bound. It is reduced to a
/// quarter of the height of the triangle where that is less, down to [`LEAST_CLEAR`].
const CLEAR: f64 = 4.0;
const LEAST_CLEAR: f64 = 0.5;

/// The offset that moves a point with barycentric coordinates (u, v) within its triangle to a distance of [`CLEAR`]
/// times its error bound from the edges, measured in the plane of the triangle; zero where the point is that far away.
/// `winding` is the cross product of the same corners.
///
/// A point that is rounded onto an edge also lies on the neighbouring wall or behind it. At a concave edge, the offset
/// along one normal does not leave the other wall, and the next ray would start outside the room. At a corner the
/// offsets from both edges are added, which leaves a fraction 1 − cos of their angle of the clearance. An offset of one
/// error bound then remains in front of any neighbour at more than 20° (a wider angle where the clearance had to be
/// reduced); closer to a sharper concave edge, a ray can still leak. *Approximation*: rays from points this close to an
/// edge start up to eight error bounds away from their position, in its plane; the position itself is not moved. On a
/// triangle that is too thin for this, ray origins are not moved either. In a mirror, a light no wider than the offset
/// would lose flux, so [`crate::Accel::surface`] undoes offsets that no adjacent geometry requires.
#[inline(always)]
fn clear_of_edges(corners: [DVec3; 3], winding: DVec3, u: f32, v: f32, error: DVec3) -> DVec3 {
    let [a, b, c] = corners;
    let edges = [c - b, a - c, b - a];
    let longest = edges.map(|e| e.length_squared()).into_iter().fold(0.0, f64::max);
    let (u, v) = (f64::from(u), f64::from(v));
    let bary = [1.0 - u - v, u, v];
    let nearest = bary[0].min(u).min(v).max(0.0);
    let (area, bound) = (winding.length_squared(), error.length_squared());
    // Negated so that NaN results in no offset.
    let is_near = nearest * nearest * area < CLEAR * CLEAR * bound * longest;
    if !(is_near && area >= 16.0 * LEAST_CLEAR * LEAST_CLEAR * bound * longest) {
        return DVec3::ZERO;
    }
    let height = (area / longest).sqrt();
    inward(edges, bary, winding, (CLEAR * bound.sqrt()).min(0.25 * height))
}

/// The barycentric coordinate from which on [`clear_of_edges`] moves no point of the triangle: a point all of whose
/// coordinates, rounded to f32, are larger is far enough from the edges. Infinite for a triangle without area.
///
/// The coordinates sum to one, so that the error bound of any such point is at most that of a point with the largest
/// coordinates of all corners. The millionth exceeds the rounding of this number, of the coordinates, and of the
/// comparison in `clear_of_edges`.
pub(crate) fn clear_from(corners: [Vec3; 3]) -> f32 {
    let [a, b, c] = corners.map(|c| c.as_dvec3());
    let error = test_error(a.abs().max(b.abs()).max(c.abs()), 7);
    let longest = [c - b, a - c, b - a].map(|e| e.length_squared()).into_iter().fold(0.0, f64::max);
    let (area, bound) = (cross([a, b, c]).length_squared(), error.length_squared());
    let least = CLEAR * (bound * longest / area).sqrt() * (1.0 + 1e-6);
    if least.is_finite() { least as f32 } else { f32::INFINITY }
}

/// The sum of the offsets from each edge to a distance of `margin` from it.
#[cold]
fn inward(edges: [DVec3; 3], bary: [f64; 3], winding: DVec3, margin: f64) -> DVec3 {
    let area = winding.length();
    let way = |(edge, bary): (DVec3, f64)| {
        let length = edge.length();
        let missing = margin - bary * area / length;
        if missing > 0.0 { winding.cross(edge) * (missing / (area * length)) } else { DVec3::ZERO }
    };
    edges.into_iter().zip(bary).map(way).sum()
}

/// `n`, negated if necessary to be in the hemisphere of `ng`.
pub(crate) fn facing(n: DVec3, ng: DVec3) -> DVec3 {
    if n.dot(ng) < 0.0 { -n } else { n }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn winding_decides_the_front_and_shading_normals_follow_it() {
        let t = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let s = Surface::on_triangle(t, None, 0.25, 0.5);
        assert_eq!((s.p, s.ng, s.ns), (Vec3::new(0.25, 0.5, 0.0), Vec3::Z, Vec3::Z));
        let s = Surface::on_triangle([t[0], t[2], t[1]], None, 0.25, 0.5);
        assert_eq!(s.ng, -Vec3::Z);
        let down = Vec3::new(0.6, 0.0, -0.8);
        let s = Surface::on_triangle(t, Some([down; 3]), 0.25, 0.5);
        assert!((s.ns + down).length() < 1e-7);
        let cancel = [Vec3::X, -Vec3::X, Vec3::ZERO];
        let s = Surface::on_triangle(t, Some(cancel), 0.5, 0.0);
        assert_eq!(s.ns, s.ng);
        let s = Surface::on_triangle(t, Some([Vec3::NAN; 3]), 0.5, 0.0);
        assert_eq!(s.ns, s.ng);
    }

    #[test]
    fn a_point_on_an_edge_moves_into_its_triangle_and_no_farther() {
        let t = [Vec3::new(5.0, 1.0, 2.0), Vec3::new(8.0, 1.0, 2.0), Vec3::new(5.0, 5.0, 2.0)];
        let (u, v) = (0.4, 0.0);
        let s = Surface::on_triangle(t, None, u, v);
        let bound = s.p_error.as_dvec3().length();
        let moved = s.start.as_dvec3() - weighted(t, u, v).0;
        // The position is rounded to f32, by up to 1/14 of the bound.
        assert!(moved.y > 3.9 * bound && moved.length() < 4.15 * bound, "{moved:?} {bound}");
        // At a right-angled corner and at an acute one.
        for (u, v, least) in [(0.0, 0.0, 3.9), (1.0, 0.0, 4.0 * (1.0 - 0.6) - 0.1)] {
            let s = Surface::on_triangle(t, None, u, v);
            let (p, bound) = (s.start.as_dvec3(), s.p_error.as_dvec3().length());
            let from = (p.y - 1.0).min(p.x - 5.0).min((35.0 - 4.0 * p.x - 3.0 * p.y) / 5.0);
            assert!(from > least * bound, "{u} {from} {bound}");
        }
        assert_eq!(Surface::on_triangle(t, None, 0.3, 0.3).start, weighted(t, 0.3, 0.3).0.as_vec3());
        assert_eq!(Surface::on_triangle(t, None, 0.0, 0.0).p, t[0]);
        // A thin triangle: the offset is a quarter of its height.
        let thin = [t[0], t[1], Vec3::new(5.0, 1.0 + 2e-5, 2.0)];
        let height = f64::from(thin[2].y - 1.0);
        let moved = Surface::on_triangle(thin, None, 0.4, 0.0).start.as_dvec3().y - 1.0;
        assert!((moved / height - 0.25).abs() < 0.02, "{moved} {height}");
        // A triangle too thin for an offset.
        let thin = [t[0], t[1], Vec3::new(5.0, 1.0 + 1e-6, 2.0)];
        assert_eq!(Surface::on_triangle(thin, None, 0.4, 0.0).start.y, 1.0);
    }

    #[test]
    fn a_facet_is_lifted_to_the_planes_of_its_corners_and_on_the_round_side_only() {
        // A face of the octahedron: the planes x = 1, y = 1, z = 1 are each 2/3 from the centre of the face.
        let corners = [DVec3::X, DVec3::Y, DVec3::Z];
        let third = 1.0f32 / 3.0;
        let up = lift(corners, corners, third, third, DVec3::ONE);
        assert!((up - DVec3::splat(2.0 / 9.0)).length() < 1e-7, "{up}");
        // The orientation of the normals does not matter.
        assert_eq!(lift(corners, corners.map(|n| -n), third, third, DVec3::ONE), up);
        assert_eq!(lift(corners, corners, third, third, DVec3::NEG_ONE), DVec3::ZERO);
        // Corners are on the surface, and the offset on an edge does not depend on the third corner.
        assert_eq!(lift(corners, corners, 0.0, 0.0, DVec3::ONE), DVec3::ZERO);
        let other = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
        assert_eq!(lift(corners, corners, 0.5, 0.0, DVec3::ONE), lift(other, other, 0.5, 0.0, DVec3::ONE));
        let flat = [DVec3::new(0.6, 0.0, 0.8); 3];
        let plane = [DVec3::ZERO, DVec3::Y, DVec3::new(0.8, 0.0, -0.6)];
        assert!(lift(plane, flat, third, third, flat[0]).length() < 1e-15);
    }

    #[test]
    fn the_bound_holds_and_tiny_triangles_have_normals() {
        let s = 1e-30f32;
        let t = [Vec3::ZERO, Vec3::new(s, 0.0, 0.0), Vec3::new(0.0, 0.0, s)];
        assert_eq!(Surface::on_triangle(t, None, 0.3, 0.3).ng, -Vec3::Y);
        let c = [Vec3::new(1e5, 3.0, -7.0), Vec3::new(-2e5, 1.0, 0.1), Vec3::new(0.3, 1e4, 1e-3)];
        let s = Surface::on_triangle(c, None, 0.37, 0.21);
        let (exact, _) = weighted(c, 0.37, 0.21);
        assert!((s.p.as_dvec3() - exact).abs().cmple(s.p_error.as_dvec3()).all());
    }
}
