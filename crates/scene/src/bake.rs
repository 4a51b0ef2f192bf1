//! Transformation of meshes from object space to render space: positions, winding, normals and tangents under any
//! affine placement.
//!
//! Transforms are applied in f64 and rounded once. Normals are transformed by the cofactor matrix, which needs no
//! inverse and is therefore valid for singular placements [Turkowski 1990]. A mirroring placement (negative
//! determinant) swaps the winding, so that the front side remains the image of the front side, as glTF requires.
//! Triangles of zero area are removed: no ray can hit them, and their normals are undefined.
use crate::{Placement, Space};
use dapple_geometry::Mesh;
use glam::{DMat3, DVec3, Vec2, Vec3, Vec4};

/// A mesh in render space, with counts of the changes made to it.
pub(crate) struct Baked {
    pub mesh: Mesh,
    /// Number of removed triangles of zero area.
    pub dropped: usize,
    /// Number of texture coordinates and colours that were not valid (replaced by zero, or white).
    pub repaired: usize,
}

/// Describes the first problem of a mesh, or returns None.
pub(crate) fn fault(mesh: &Mesh) -> Option<String> {
    let n = mesh.positions.len();
    if let Some((i, p)) = not_finite(&mesh.positions) {
        return Some(says_not_finite(i, p));
    }
    if let Some(what) = out_of_range(&mesh.triangles, n) {
        return Some(what);
    }
    let lengths = [
        ("normals", mesh.normals.len()),
        ("tangents", mesh.tangents.len()),
        ("texture coordinates", mesh.uv[0].len()),
        ("second texture coordinates", mesh.uv[1].len()),
        ("colours", mesh.colors.len()),
    ];
    let (name, m) = lengths.into_iter().find(|&(_, m)| m != 0 && m != n)?;
    Some(format!("has {m} {name} for {n} vertices"))
}

/// Index and position of the first vertex that is not finite.
pub(crate) fn not_finite(positions: &[Vec3]) -> Option<(usize, Vec3)> {
    positions.iter().copied().enumerate().find(|(_, p)| !p.is_finite())
}

/// Describes a vertex that is not finite.
pub(crate) fn says_not_finite(i: usize, p: Vec3) -> String {
    format!("vertex {i} is at ({}, {}, {}), which is not finite", p.x, p.y, p.z)
}

/// Describes the first triangle with a corner that is none of `n` vertices.
pub(crate) fn out_of_range(triangles: &[[u32; 3]], n: usize) -> Option<String> {
    let bad = |t: &[u32; 3]| t.iter().any(|&i| i as usize >= n);
    let t = triangles.iter().position(bad)?;
    let [a, b, c] = triangles[t];
    Some(format!("triangle {t} has corners {a}, {b}, {c}, but there are {n} vertices"))
}

/// Whether a triangle has a positive area, from the cross product of its edges in f64, which is accurate enough for f32
/// corners.
pub(crate) fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a) != DVec3::ZERO
}

/// World-space bounding box of the triangles with positive area in object space; None without any.
pub(crate) fn bounds(mesh: &Mesh, placement: &Placement) -> Option<(DVec3, DVec3)> {
    let mut seen = vec![false; mesh.positions.len()];
    for t in &mesh.triangles {
        if has_area(t.map(|i| mesh.positions[i as usize])) {
            t.iter().for_each(|&i| seen[i as usize] = true);
        }
    }
    let used = mesh.positions.iter().zip(&seen).filter(|(_, seen)| **seen);
    used.map(|(p, _)| placement.point(p.as_dvec3())).fold(None, |so_far, p| match so_far {
        None => Some((p, p)),
        Some((min, max)) => Some((p.min(min), p.max(max))),
    })
}

/// Transforms a mesh to render space. It must have no [`fault`], and the placement must be finite.
pub(crate) fn bake(mesh: &Mesh, placement: &Placement, space: &Space) -> Baked {
    let directions = Directions::new(&placement.linear);
    let positions: Vec<Vec3> =
        mesh.positions.iter().map(|p| space.place(placement, p.as_dvec3()).as_vec3()).collect();
    let mut triangles = mesh.triangles.clone();
    if directions.mirrored {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    triangles.retain(|t| has_area(t.map(|i| positions[i as usize])));
    let dropped = mesh.triangles.len() - triangles.len();
    let mut baked = Mesh {
        positions,
        triangles,
        normals: mesh.normals.iter().map(|n| directions.normal(*n)).collect(),
        tangents: mesh.tangents.iter().map(|t| directions.tangent(*t)).collect(),
        uv: mesh.uv.clone(),
        colors: mesh.colors.clone(),
    };
    let repaired = sanitize(&mut baked);
    Baked { mesh: compact(baked), dropped, repaired }
}

/// Transforms of directions from object to render space.
struct Directions {
    linear: DMat3,
    /// Columns a₂×a₃, a₃×a₁, a₁×a₂, times the sign of the determinant.
    normals: DMat3,
    mirrored: bool,
}

impl Directions {
    fn new(linear: &DMat3) -> Self {
        // Only directions matter here: scale the matrix to near 1 so that the products below stay in range.
        let largest = [linear.x_axis, linear.y_axis, linear.z_axis].map(|c| c.abs().max_element());
        let largest = largest[0].max(largest[1]).max(largest[2]);
        let m = if largest > 0.0 { *linear * (1.0 / largest) } else { *linear };
        let cofactor =
            DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let mirrored = m.x_axis.dot(cofactor.x_axis) < 0.0;
        Self { linear: m, normals: if mirrored { -cofactor } else { cofactor }, mirrored }
    }

    /// Unit image of a normal; zero if it has no direction.
    fn normal(&self, n: Vec3) -> Vec3 {
        unit(self.normals * n.as_dvec3())
    }

    /// Image of a tangent; mirroring also reverses the bitangent n × t.
    fn tangent(&self, t: Vec4) -> Vec4 {
        let sign = if (t.w < 0.0) != self.mirrored { -1.0 } else { 1.0 };
        unit(self.linear * t.truncate().as_dvec3()).extend(sign)
    }
}

/// Normalises a vector in f64; zero if it has no direction. The vector is first scaled to a largest component of 1, so
/// that squares stay in range.
fn unit(v: DVec3) -> Vec3 {
    let largest = v.abs().max_element();
    if !(largest > 0.0 && v.is_finite()) {
        return Vec3::ZERO;
    }
    let v = v * (1.0 / largest);
    if v.is_finite() { (v * (1.0 / v.length())).as_vec3() } else { Vec3::ZERO }
}

/// Replaces invalid attributes: missing vertex normals by a face normal, non-finite texture coordinates by zero,
/// non-finite or negative colours by white. Returns the number of the latter two.
fn sanitize(mesh: &mut Mesh) -> usize {
    if mesh.normals.contains(&Vec3::ZERO) {
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
            let ng = unit((b - a).cross(c - a));
            for &i in t {
                let n = &mut mesh.normals[i as usize];
                *n = if *n == Vec3::ZERO { ng } else { *n };
            }
        }
    }
    let mut count = 0;
    for uv in mesh.uv.iter_mut().flatten().filter(|uv| !uv.is_finite()) {
        *uv = Vec2::ZERO;
        count += 1;
    }
    for color in mesh.colors.iter_mut().filter(|c| !c.is_finite() || c.min_element() < 0.0) {
        *color = Vec4::ONE;
        count += 1;
    }
    count
}

/// Removes the vertices that no triangle uses.
pub(crate) fn compact(mesh: Mesh) -> Mesh {
    const UNUSED: u32 = u32::MAX;
    let mut order = vec![UNUSED; mesh.positions.len()];
    for &i in mesh.triangles.iter().flatten() {
        order[i as usize] = 0;
    }
    let kept: Vec<usize> = (0..order.len()).filter(|&i| order[i] == 0).collect();
    if kept.len() == order.len() {
        return mesh;
    }
    for (new, &old) in kept.iter().enumerate() {
        order[old] = new as u32;
    }
    pick(&mesh, &kept, mesh.triangles.iter().map(|t| t.map(|i| order[i as usize])).collect())
}

/// A mesh with the given triangles, whose vertex i is vertex `kept[i]` of `mesh`.
pub(crate) fn pick(mesh: &Mesh, kept: &[usize], triangles: Vec<[u32; 3]>) -> Mesh {
    fn of<T: Copy>(all: &[T], kept: &[usize]) -> Vec<T> {
        if all.is_empty() { Vec::new() } else { kept.iter().map(|&i| all[i]).collect() }
    }
    Mesh {
        positions: of(&mesh.positions, kept),
        triangles,
        normals: of(&mesh.normals, kept),
        tangents: of(&mesh.tangents, kept),
        uv: [of(&mesh.uv[0], kept), of(&mesh.uv[1], kept)],
        colors: of(&mesh.colors, kept),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;

    fn triangle() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            normals: vec![Vec3::Z; 3],
            tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3],
            ..Mesh::default()
        }
    }

    fn baked(mesh: &Mesh, scale: DVec3) -> Baked {
        bake(mesh, &DAffine3::from_scale(scale).into(), &Space::IDENTITY)
    }

    fn winding_normal(mesh: &Mesh) -> Vec3 {
        let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
        (b - a).cross(c - a).normalize()
    }

    #[test]
    fn every_mirror_keeps_the_front_in_front() {
        for signs in 0..8 {
            let s = |bit: i32| if signs & bit != 0 { -1.0 } else { 1.0 };
            let scale = DVec3::new(s(1), s(2), s(4));
            let out = baked(&triangle(), scale).mesh;
            // The image of a point above the front side stays above it.
            let above = (DVec3::Z * scale).as_vec3();
            assert_eq!(winding_normal(&out), above, "{scale}");
            assert_eq!(out.normals[0], above, "{scale}");
            // Bitangent n × t · w is the image of the bitangent +y.
            let t = out.tangents[0];
            assert_eq!(above.cross(t.truncate()) * t.w, (DVec3::Y * scale).as_vec3(), "{scale}");
        }
    }

    #[test]
    fn normals_stay_perpendicular_under_shear() {
        let linear =
            DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.5, 2.0, 0.3), DVec3::new(0.0, 0.7, 0.1));
        let placement = Placement { linear, ..Placement::IDENTITY };
        let out = bake(&triangle(), &placement, &Space::IDENTITY).mesh;
        assert!((out.normals[0] - winding_normal(&out)).length() < 1e-6);
    }

    #[test]
    fn flattened_and_vanishing_scales() {
        let flat = baked(&triangle(), DVec3::new(1.0, 1.0, 0.0));
        assert_eq!((flat.dropped, flat.mesh.normals[0]), (0, Vec3::Z));
        for z in [1e-20, 1e-200] {
            let thin = baked(&triangle(), DVec3::new(1.0, 1.0, z));
            assert_eq!((thin.dropped, thin.mesh.normals[0]), (0, Vec3::Z));
        }
        let gone = baked(&triangle(), DVec3::ZERO);
        assert_eq!((gone.dropped, gone.mesh.triangles.len(), gone.mesh.positions.len()), (1, 0, 0));
        let huge = baked(&triangle(), DVec3::new(1.0, 1e6, 1e-6)).mesh;
        assert_eq!(huge.normals[0], Vec3::Z);
    }

    #[test]
    fn zero_area_is_dropped_and_vertices_follow() {
        let mut mesh = triangle();
        mesh.positions.extend([Vec3::splat(9.0), Vec3::new(2.0, 0.0, 0.0)]);
        mesh.normals.extend([Vec3::Z; 2]);
        mesh.tangents.clear();
        mesh.triangles.extend([[0, 1, 4], [2, 2, 1]]);
        mesh.triangles.swap(0, 2);
        let out = baked(&mesh, DVec3::ONE);
        assert_eq!(out.dropped, 2);
        assert_eq!(out.mesh.triangles, [[0, 1, 2]]);
        assert_eq!(out.mesh.positions.len(), 3);
    }

    #[test]
    fn slivers_of_f32_corners_are_judged_exactly() {
        let a = Vec3::new(100.0, 100.0, 0.0);
        assert!(has_area([a, a + Vec3::X, a + Vec3::new(2.0, f32::EPSILON * 64.0, 0.0)]));
        assert!(!has_area([a, a + Vec3::X, a + Vec3::X * 2.0]));
        assert!(!has_area([a, a, a]));
    }

    #[test]
    fn missing_normals_and_numbers_are_repaired() {
        let mut mesh = triangle();
        mesh.normals[1] = Vec3::new(f32::NAN, 0.0, 0.0);
        mesh.uv[0] = vec![Vec2::new(f32::INFINITY, 0.0), Vec2::ONE, Vec2::ONE];
        let out = baked(&mesh, DVec3::ONE);
        assert_eq!((out.mesh.normals[1], out.mesh.uv[0][0], out.repaired), (Vec3::Z, Vec2::ZERO, 1));
    }

    #[test]
    fn faults_are_found_before_anything_is_done() {
        let nan = Mesh { positions: vec![Vec3::new(0.0, f32::NAN, 0.0)], ..Mesh::default() };
        assert!(fault(&nan).unwrap().contains("vertex 0"));
        let mut range = triangle();
        range.triangles.push([0, 1, 3]);
        assert!(fault(&range).unwrap().contains("triangle 1"));
        let mut lengths = triangle();
        lengths.normals.pop();
        assert!(fault(&lengths).unwrap().contains("2 normals for 3 vertices"));
        assert_eq!(fault(&triangle()), None);
    }
}
