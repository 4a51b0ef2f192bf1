//! Generation of tangents for normal maps if the file has none: MikkTSpace [Mikkelsen 2008], by the crate
//! `bevy_mikktspace`.
//!
//! The texture coordinates are those with which the normal map is looked up, including its KHR_texture_transform. In
//! glTF v points down, in MikkTSpace up, hence the sign of w is reversed: +w·(n × t) is the up direction of the image.
use crate::{bake, material::TextureUse};
use bevy_mikktspace::{Geometry, Ops, TangentSpace};
use dapple_geometry::Mesh;
use glam::{Vec2, Vec3, Vec4};

/// Adds a tangent to every vertex; vertices whose corners have different tangents are split. The mesh is unchanged if
/// it has no texture coordinates.
pub(crate) fn with_tangents(mesh: Mesh, normal_map: &TextureUse) -> Mesh {
    let uv = &mesh.uv[normal_map.uv_set as usize & 1];
    if uv.is_empty() || mesh.triangles.is_empty() {
        return mesh;
    }
    let mut corners = Corners {
        mesh: &mesh,
        uv: uv.iter().map(|&uv| normal_map.apply(uv)).collect(),
        tangents: vec![Vec4::ZERO; mesh.triangles.len() * 3],
    };
    // The error type is uninhabited.
    let _ = bevy_mikktspace::generate_tangents::<_, LibmOps>(&mut corners);
    let tangents = corners.tangents;
    weld(&mesh, &tangents)
}

/// Maximum number of copies of a vertex that are compared before another one is added; keeps the cost linear for fans
/// of any size.
const LONGEST_SEARCH: usize = 16;

/// Shares vertices between corners of equal tangent; a corner with a different tangent gets a separate vertex.
fn weld(mesh: &Mesh, tangents: &[Vec4]) -> Mesh {
    const NONE: u32 = u32::MAX;
    // Linked list of the new vertices of each old one.
    let mut first = vec![NONE; mesh.positions.len()];
    let mut next: Vec<u32> = Vec::new();
    let (mut kept, mut chosen): (Vec<usize>, Vec<Vec4>) = (Vec::new(), Vec::new());
    let mut triangles = mesh.triangles.clone();
    for (corner, index) in triangles.iter_mut().flatten().enumerate() {
        let (old, tangent) = (*index as usize, tangents[corner]);
        let mut new = first[old];
        for _ in 0..LONGEST_SEARCH {
            if new == NONE || chosen[new as usize] == tangent {
                break;
            }
            new = next[new as usize];
        }
        if new == NONE || chosen[new as usize] != tangent {
            new = kept.len() as u32;
            next.push(std::mem::replace(&mut first[old], new));
            kept.push(old);
            chosen.push(tangent);
        }
        *index = new;
    }
    let mut out = bake::pick(mesh, &kept, triangles);
    out.tangents = chosen;
    out
}

struct Corners<'a> {
    mesh: &'a Mesh,
    uv: Vec<Vec2>,
    tangents: Vec<Vec4>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, vert: usize) -> usize {
        self.mesh.triangles[face][vert] as usize
    }
}

impl Geometry<LibmOps> for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, vert)].to_array()
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        if let Some(n) = self.mesh.normals.get(self.vertex(face, vert)) {
            return n.to_array();
        }
        let [a, b, c] = self.mesh.triangles[face].map(|i| self.mesh.positions[i as usize]);
        (b - a).cross(c - a).normalize_or(Vec3::Z).to_array()
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.uv[self.vertex(face, vert)].to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, vert: usize) {
        let tangent = space.map_or(Vec4::ZERO, |s| Vec4::from_array(s.tangent_encoded()));
        // Adding zero removes negative zeros, so that equal tangents have equal bits.
        let tangent = tangent * Vec4::new(1.0, 1.0, 1.0, -1.0) + Vec4::ZERO;
        self.tangents[face * 3 + vert] = if tangent.is_finite() { tangent } else { Vec4::ZERO };
    }
}

/// Math functions of libm: the acos of the platform may differ between machines.
struct LibmOps;

impl Ops for LibmOps {
    fn sqrt(x: f32) -> f32 {
        libm::sqrtf(x)
    }

    fn acos(x: f32) -> f32 {
        libm::acos(f64::from(x)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unit square facing +z; u to the right, v down as in glTF.
    fn square() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            normals: vec![Vec3::Z; 4],
            uv: [vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO], Vec::new()],
            ..Mesh::default()
        }
    }

    #[test]
    fn up_in_the_image_is_up_in_space() {
        let out = with_tangents(square(), &TextureUse::new(0));
        assert_eq!(out.positions.len(), 4);
        for t in &out.tangents {
            assert!((t.truncate() - Vec3::X).length() < 1e-6);
            assert!((Vec3::Z.cross(t.truncate()) * t.w - Vec3::Y).length() < 1e-6);
        }
    }

    #[test]
    fn a_turned_texture_turns_the_tangent() {
        let turned = glam::Affine2::from_mat2(glam::Mat2::from_cols(Vec2::Y, -Vec2::X));
        let map = TextureUse { transform: Some(turned), ..TextureUse::new(0) };
        let out = with_tangents(square(), &map);
        // u' = −v, and v runs down: the direction of growing u' is up.
        assert!((out.tangents[0].truncate() - Vec3::Y).length() < 1e-6);
    }

    #[test]
    fn mirrored_halves_split_their_seam() {
        let mut mesh = square();
        mesh.positions.extend([Vec3::new(2.0, 0.0, 0.0), Vec3::new(2.0, 1.0, 0.0)]);
        mesh.normals.extend([Vec3::Z; 2]);
        mesh.uv[0].extend([Vec2::Y, Vec2::ZERO]);
        mesh.triangles.extend([[1, 4, 5], [1, 5, 2]]);
        let out = with_tangents(mesh, &TextureUse::new(0));
        assert_eq!(out.positions.len(), 8, "the two seam vertices are doubled");
        assert_eq!(out.tangents[out.triangles[0][0] as usize].w, 1.0);
        assert_eq!(out.tangents[out.triangles[2][0] as usize].w, -1.0);
    }

    #[test]
    fn degenerate_coordinates_do_no_harm() {
        let mut mesh = square();
        mesh.uv[0] = vec![Vec2::ONE; 4];
        mesh.normals.clear();
        let out = with_tangents(mesh, &TextureUse::new(0));
        assert!(out.tangents.iter().all(|t| t.is_finite()));
        assert_eq!(out.triangles.len(), 2);
    }
}
