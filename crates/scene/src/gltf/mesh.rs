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
    let (count, all) = (doc.count(positions, place)?, triangle_count(doc, primitive, place)?);
    if !has_data(doc, positions) {
        // All vertices coincide.
        doc.zeros(count, place)?;
        if all > 0 {
            doc.warn(coinciding(place, all, all));
        }
        return Ok(None);
    }
    doc.check(positions, place)?;
    let Ok(count) = u32::try_from(count) else {
        return Err(doc.invalid(place, "has more vertices than 32-bit indices can address; split the mesh"));
    };
    let indices = primitive.indices.map(|i| doc.indices(i, place)).transpose()?;
    let triangles = Order { indices, vertices: count }.triangles(mode);
    if let Some(what) = bake::out_of_range(&triangles, count as usize) {
        return Err(doc.invalid(place, what));
    }
    // Primitives often share one large vertex buffer: of each, only the vertices that its triangles use are read.
    let used = Used::by(triangles, count);
    let mut mesh = attributes(doc, primitive, place, wanted, &used)?;
    if let Some((i, p)) = bake::not_finite(&mesh.positions) {
        return Err(doc.invalid(place, bake::says_not_finite(used.vertex(i), p)));
    }
    mesh.triangles = used.triangles;
    drop_degenerate(doc, &mut mesh, place);
    let mesh = bake::compact(mesh);
    doc.keep(bytes(&mesh), place)?;
    Ok((!mesh.triangles.is_empty()).then_some(mesh))
}

/// Reads the attributes of the used vertices. The position accessor exists.
fn attributes(
    doc: &Document<'_>,
    primitive: &json::mesh::Primitive,
    place: &str,
    wanted: &Wanted,
    used: &Used,
) -> Result<Mesh, SceneError> {
    let find = |semantic, is_wanted: bool, name| {
        let accessor = primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let Some(accessor) = accessor.filter(|_| is_wanted) else { return Ok(None) };
        let count = doc.count(accessor, place)?;
        match count == u64::from(used.of) || count == 0 {
            true => Ok(Some(accessor).filter(|_| count > 0)),
            false => Err(doc.invalid(place, format!("has {count} {name} for {} vertices", used.of))),
        }
    };
    let mut mesh = Mesh::default();
    let at = used.vertices.as_deref();
    if let Some(index) = find(Semantic::Positions, true, "positions")? {
        mesh.positions = doc.vectors_at(index, at, place)?.into_iter().map(Vec3::from_array).collect();
    }
    if let Some(index) = find(Semantic::Normals, wanted.normals, "normals")? {
        mesh.normals = doc.vectors_at(index, at, place)?.into_iter().map(Vec3::from_array).collect();
    }
    if let Some(index) = find(Semantic::Tangents, wanted.tangents, "tangents")? {
        mesh.tangents = doc.vectors_at(index, at, place)?.into_iter().map(Vec4::from_array).collect();
    }
    for (set, name) in [(0, "texture coordinates"), (1, "second texture coordinates")] {
        let semantic = Semantic::TexCoords(set as u32);
        if let Some(index) = find(semantic.clone(), wanted.uv[set], name)? {
            mesh.uv[set] = doc.vectors_at(index, at, place)?.into_iter().map(Vec2::from_array).collect();
        } else if wanted.uv[set] && !primitive.attributes.contains_key(&Checked::Valid(semantic)) {
            doc.warn(format!("{place} has no TEXCOORD_{set}, so its textures show a single texel: add UVs"));
        }
    }
    if let Some(index) = find(Semantic::Colors(0), wanted.colors, "colours")? {
        mesh.colors = doc.colors_at(index, at, place)?.into_iter().map(Vec4::from_array).collect();
    }
    Ok(mesh)
}

/// Whether the positions of a primitive exist only in compressed form; the warning about the extension covers this.
fn is_compressed_only(
    doc: &Document<'_>,
    primitive: &json::mesh::Primitive,
    positions: Index<json::Accessor>,
) -> bool {
    primitive.extensions.as_ref().is_some_and(|e| e.others.contains_key(extensions::DRACO))
        && !has_data(doc, positions)
}

/// Whether an accessor has data; the elements of one without are zero.
fn has_data(doc: &Document<'_>, accessor: Index<json::Accessor>) -> bool {
    let has_data = |a: &json::Accessor| a.buffer_view.is_some() || a.sparse.is_some();
    doc.root.accessors.get(accessor.value()).is_none_or(has_data)
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
        doc.warn(coinciding(place, left_out as u64, all as u64));
    }
}

fn coinciding(place: &str, left_out: u64, all: u64) -> String {
    format!("{place}: {left_out} of {all} triangles have two coinciding corners and are left out")
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

/// The vertices of a primitive that its triangles use.
struct Used {
    /// Their indices in increasing order; None if all vertices are used.
    vertices: Option<Vec<u32>>,
    /// Number of vertices of the primitive.
    of: u32,
    /// Triangles, whose corners are positions in `vertices`.
    triangles: Vec<[u32; 3]>,
}

impl Used {
    /// The vertices that `triangles`, whose corners are less than `of`, use. The work depends on the number of
    /// triangles, not on `of`.
    fn by(mut triangles: Vec<[u32; 3]>, of: u32) -> Self {
        let corners = || triangles.iter().flatten().copied();
        let is_sparse = 3 * triangles.len() < of as usize / 8;
        let mut places = vec![0; if is_sparse { 0 } else { of as usize }];
        let mut vertices: Vec<u32> = if is_sparse {
            corners().collect()
        } else {
            corners().for_each(|i| places[i as usize] = 1);
            (0..of).filter(|i| places[*i as usize] == 1).collect()
        };
        if vertices.len() == of as usize {
            return Self { vertices: None, of, triangles };
        }
        vertices.sort_unstable();
        vertices.dedup();
        if is_sparse {
            let place = |i: u32| vertices.binary_search(&i).unwrap_or(0) as u32;
            triangles.iter_mut().for_each(|t| *t = t.map(place));
        } else {
            (0..).zip(&vertices).for_each(|(place, i)| places[*i as usize] = place);
            triangles.iter_mut().for_each(|t| *t = t.map(|i| places[i as usize]));
        }
        Self { vertices: Some(vertices), of, triangles }
    }

    /// Index in the file of the i-th used vertex.
    fn vertex(&self, i: usize) -> usize {
        self.vertices.as_ref().map_or(i, |vertices| vertices[i] as usize)
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
    fn used_vertices_are_the_same_by_both_ways() {
        let triangles = vec![[7, 2, 9], [9, 2, 4]];
        let few = Used::by(triangles.clone(), 1000);
        let many = Used::by(triangles.clone(), 10);
        for used in [&few, &many] {
            assert_eq!(used.vertices.as_deref(), Some(&[2, 4, 7, 9][..]));
            assert_eq!(used.triangles, [[2, 0, 3], [3, 0, 1]]);
            assert_eq!(used.vertex(2), 7);
        }
        let all = Used::by(vec![[2, 0, 1]], 3);
        assert!(all.vertices.is_none() && all.triangles == [[2, 0, 1]] && all.vertex(2) == 2);
        assert_eq!(Used::by(Vec::new(), 5).vertices, Some(Vec::new()));
    }

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
