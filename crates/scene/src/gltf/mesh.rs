//! Conversion of glTF primitives to triangle meshes.
use super::{
    document::{Document, label},
    extensions,
};
use crate::{Reads, SceneError, TexturedMaterial, bake};
use dapple_geometry::Mesh;
use glam::{Vec2, Vec3, Vec4};
use gltf::json::{
    self, Index,
    mesh::{Mode, Semantic},
    validation::Checked,
};

/// The attributes that are read of a primitive: only those that its material uses.
pub(super) struct Wanted {
    pub uv: [bool; 2],
    pub normals: bool,
    pub tangents: bool,
    pub colors: bool,
}

impl Wanted {
    pub fn by(material: &TexturedMaterial, reads: &Reads) -> Self {
        let uses = |set| material.textures().any(|t| t.uv_set == set);
        Self {
            uv: [uses(0), uses(1)],
            normals: reads.shading_normals() && (reads.everything || !material.unlit),
            tangents: reads.everything || material.normal_texture.is_some(),
            colors: reads.base_color(material),
        }
    }
}

/// The mesh of a primitive; None, with a warning, if there is nothing to render.
pub(super) fn read(
    doc: &Document<'_>,
    primitive: &json::mesh::Primitive,
    place: &str,
    wanted: &Wanted,
) -> Result<Option<Mesh>, SceneError> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(doc.invalid(place, "has an unknown mode"));
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        doc.warn("points and lines are left out because they have no surface: convert them to meshes".into());
        return Ok(None);
    }
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let Some(positions) = attribute(Semantic::Positions) else {
        doc.warn(format!("{place} has no POSITION attribute and is left out"));
        return Ok(None);
    };
    if is_compressed_only(doc, primitive, positions) {
        return Ok(None);
    }
    let positions: Vec<Vec3> = doc.vectors(positions, place)?.into_iter().map(Vec3::from_array).collect();
    if u32::try_from(positions.len()).is_err() {
        return Err(doc.invalid(place, "has more vertices than 32-bit indices can address; split the mesh"));
    }
    let indices = primitive.indices.map(|i| doc.indices(i, place)).transpose()?;
    let order = Order { indices, vertices: positions.len() as u32 };
    let mut mesh = Mesh { triangles: order.triangles(mode), positions, ..Mesh::default() };
    if let Some(normals) = attribute(Semantic::Normals).filter(|_| wanted.normals) {
        mesh.normals = doc.vectors(normals, place)?.into_iter().map(Vec3::from_array).collect();
    }
    if let Some(tangents) = attribute(Semantic::Tangents).filter(|_| wanted.tangents) {
        mesh.tangents = doc.vectors(tangents, place)?.into_iter().map(Vec4::from_array).collect();
    }
    for (set, uv) in mesh.uv.iter_mut().enumerate().filter(|(set, _)| wanted.uv[*set]) {
        match attribute(Semantic::TexCoords(set as u32)) {
            Some(index) => *uv = doc.vectors(index, place)?.into_iter().map(Vec2::from_array).collect(),
            None => doc
                .warn(format!("{place} has no TEXCOORD_{set}, so its textures show a single texel: add UVs")),
        }
    }
    if let Some(colors) = attribute(Semantic::Colors(0)).filter(|_| wanted.colors) {
        mesh.colors = doc.colors(colors, place)?.into_iter().map(Vec4::from_array).collect();
    }
    if let Some(what) = bake::fault(&mesh) {
        return Err(doc.invalid(place, what));
    }
    drop_degenerate(doc, &mut mesh, place);
    // Primitives often share one large vertex buffer.
    let mesh = bake::compact(mesh);
    doc.keep(bytes(&mesh), place)?;
    Ok((!mesh.triangles.is_empty()).then_some(mesh))
}

/// Whether the positions of a primitive exist only in compressed form; the warning about the extension covers this.
fn is_compressed_only(
    doc: &Document<'_>,
    primitive: &json::mesh::Primitive,
    positions: Index<json::Accessor>,
) -> bool {
    let has_data = |a: &json::Accessor| a.buffer_view.is_some() || a.sparse.is_some();
    primitive.extensions.as_ref().is_some_and(|e| e.others.contains_key(extensions::DRACO))
        && doc.root.accessors.get(positions.value()).is_some_and(|accessor| !has_data(accessor))
}

/// Removes triangles with two coinciding corners if they are the majority of a mesh, so that this is done once for all
/// instances. In other meshes they are removed later, together with all other triangles of zero area.
fn drop_degenerate(doc: &Document<'_>, mesh: &mut Mesh, place: &str) {
    let positions = &mesh.positions;
    let is_open = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        a != b && b != c && c != a
    };
    let (all, open) = (mesh.triangles.len(), mesh.triangles.iter().filter(|t| is_open(t)).count());
    if open < all.div_ceil(2) {
        mesh.triangles.retain(is_open);
        let left_out = all - open;
        doc.warn(format!(
            "{place}: {left_out} of {all} triangles have two coinciding corners and are left out"
        ));
    }
}

/// Size of a mesh in bytes.
fn bytes(mesh: &Mesh) -> u64 {
    let vectors = mesh.positions.len() * 12 + mesh.normals.len() * 12 + mesh.triangles.len() * 12;
    let rest = mesh.tangents.len() * 16 + mesh.colors.len() * 16;
    (vectors + rest + (mesh.uv[0].len() + mesh.uv[1].len()) * 8) as u64
}

/// Number of triangles of a primitive, from the JSON alone.
pub(super) fn triangle_count(
    doc: &Document<'_>,
    primitive: &json::mesh::Primitive,
    place: &str,
) -> Result<u64, SceneError> {
    let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).copied();
    let Some(corners) = primitive.indices.or(positions) else { return Ok(0) };
    let n = doc.count(corners, place)?;
    Ok(match primitive.mode {
        Checked::Valid(Mode::Triangles) => n / 3,
        Checked::Valid(Mode::TriangleStrip | Mode::TriangleFan) => n.saturating_sub(2),
        _ => 0,
    })
}

/// Order in which a primitive uses its vertices.
struct Order {
    indices: Option<Vec<u32>>,
    vertices: u32,
}

impl Order {
    fn len(&self) -> usize {
        self.indices.as_ref().map_or(self.vertices as usize, Vec::len)
    }

    fn corner(&self, i: usize) -> u32 {
        self.indices.as_ref().map_or(i as u32, |indices| indices[i])
    }

    /// Triangles by glTF 2.0 §3.7.2.1; incomplete triangles at the end are ignored.
    fn triangles(&self, mode: Mode) -> Vec<[u32; 3]> {
        let strip = 0..self.len().saturating_sub(2);
        match mode {
            Mode::TriangleStrip => {
                strip.map(|i| [i, i + 1 + i % 2, i + 2 - i % 2].map(|i| self.corner(i))).collect()
            }
            Mode::TriangleFan => strip.map(|i| [i + 1, i + 2, 0].map(|i| self.corner(i))).collect(),
            _ => (0..self.len() / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2].map(|i| self.corner(i))).collect(),
        }
    }
}

/// The mesh at an index, and its name in messages.
pub(super) fn named<'a>(
    doc: &'a Document<'_>,
    index: Index<json::Mesh>,
    place: &str,
) -> Result<(&'a json::Mesh, String), SceneError> {
    let mesh = doc.get(&doc.root.meshes, index, "mesh", place)?;
    Ok((mesh, label("mesh", index.value(), mesh.name.as_deref())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_front() {
        let order = Order { indices: None, vertices: 5 };
        assert_eq!(order.triangles(Mode::Triangles), [[0, 1, 2]]);
        assert_eq!(order.triangles(Mode::TriangleStrip), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(order.triangles(Mode::TriangleFan), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
        let short = Order { indices: Some(vec![7, 9]), vertices: 10 };
        for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan] {
            assert!(short.triangles(mode).is_empty());
        }
    }
}
