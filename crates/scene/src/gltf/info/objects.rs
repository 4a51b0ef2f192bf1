//! Objects of the selected scene with their triangle counts, skins, morph targets and material names.
use super::super::{
    document::{Document, label},
    instancing, mesh,
    node::{self, Hierarchy},
};
use super::{choices::own, counts::Counts};
use crate::SceneError;
use gltf::json::{self, mesh::Semantic, validation::Checked};
use serde::Serialize;
use serde_json::Value;

/// The object placed by a node of the selected scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ObjectInfo {
    /// Index of the node.
    pub node: usize,
    /// Name in images, reports and layers: that of the node, or else of the mesh.
    pub name: String,
    /// "mesh", "sphere" or "disk".
    pub kind: String,
    /// Index of the mesh.
    pub mesh: Option<usize>,
    /// Triangles of one instance.
    pub triangles: u64,
    /// Number of instances: 1, or that of EXT_mesh_gpu_instancing.
    pub instances: u64,
}

/// A skin (not applied).
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SkinInfo {
    /// Index in the file's list.
    pub index: usize,
    /// Name, if it has one.
    pub name: Option<String>,
    /// Number of joints.
    pub joints: usize,
    /// Number of nodes of the selected scene that use it.
    pub placed: usize,
}

/// The morph targets of a mesh (not applied).
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MorphInfo {
    /// Index of the mesh.
    pub mesh: usize,
    /// Name of the mesh, if it has one.
    pub name: Option<String>,
    /// Number of targets.
    pub targets: usize,
    /// Names of the targets from `extras.targetNames`.
    pub names: Vec<String>,
    /// Weights of the mesh, if given.
    pub weights: Vec<f32>,
}

/// Numbers of triangles and vertices of a mesh.
type Size = (u64, u64);

/// Lists the placed objects and adds them to `counts`.
pub(super) fn objects(
    doc: &Document<'_>,
    hierarchy: &Hierarchy,
    counts: &mut Counts,
) -> Result<Vec<ObjectInfo>, SceneError> {
    // Many nodes may share a mesh of many primitives.
    let mut sizes: Vec<Option<Size>> = vec![None; doc.root.meshes.len()];
    let mut objects = Vec::new();
    for &i in &hierarchy.order {
        let (node, place) = (&doc.root.nodes[i], node::place(doc, i));
        let shape = doc.dapple(&node.extras, &place)?.and_then(|d| d.get("shape").cloned());
        if let Some(shape) = shape {
            counts.shapes += 1;
            let kind = shape.as_str().unwrap_or("shape").to_owned();
            let name = own(node.name.as_deref()).unwrap_or(place);
            objects.push(ObjectInfo { node: i, name, kind, instances: 1, ..ObjectInfo::default() });
            continue;
        }
        let Some(index) = node.mesh else { continue };
        let (mesh, mesh_place) = mesh::named(doc, index, &place)?;
        let (triangles, vertices) = match sizes[index.value()] {
            Some(size) => size,
            None => {
                let size = size(doc, mesh, &mesh_place)?;
                counts.stored_triangles = counts.stored_triangles.saturating_add(size.0);
                *sizes[index.value()].insert(size)
            }
        };
        let instances = instancing::count(doc, i)?.unwrap_or(1);
        counts.triangles = counts.triangles.saturating_add(triangles.saturating_mul(instances));
        counts.vertices = counts.vertices.saturating_add(vertices.saturating_mul(instances));
        counts.instances = counts.instances.saturating_add(instances);
        let name = own(node.name.as_deref()).unwrap_or(mesh_place);
        let (kind, mesh) = ("mesh".to_owned(), Some(index.value()));
        objects.push(ObjectInfo { node: i, name, kind, mesh, triangles, instances });
    }
    Ok(objects)
}

fn size(doc: &Document<'_>, mesh: &json::Mesh, place: &str) -> Result<Size, SceneError> {
    let mut size: Size = (0, 0);
    for primitive in &mesh.primitives {
        size.0 = size.0.saturating_add(mesh::triangle_count(doc, primitive, place)?);
        if let Some(positions) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) {
            size.1 = size.1.saturating_add(doc.count(*positions, place)?);
        }
    }
    Ok(size)
}

pub(super) fn skins(doc: &Document<'_>, hierarchy: &Hierarchy) -> Vec<SkinInfo> {
    let mut placed = vec![0; doc.root.skins.len()];
    for skin in hierarchy.order.iter().filter_map(|&i| doc.root.nodes[i].skin) {
        if let Some(count) = placed.get_mut(skin.value()) {
            *count += 1;
        }
    }
    let one = |(index, (skin, placed)): (usize, (&json::Skin, usize))| SkinInfo {
        index,
        name: own(skin.name.as_deref()),
        joints: skin.joints.len(),
        placed,
    };
    doc.root.skins.iter().zip(placed).enumerate().map(one).collect()
}

pub(super) fn morphs(doc: &Document<'_>) -> Vec<MorphInfo> {
    let one = |(index, mesh): (usize, &json::Mesh)| {
        let targets = mesh.primitives.iter().map(|p| p.targets.as_ref().map_or(0, Vec::len)).max()?;
        let (name, weights) = (own(mesh.name.as_deref()), mesh.weights.clone().unwrap_or_default());
        let names = target_names(&mesh.extras).unwrap_or_default();
        (targets > 0).then_some(MorphInfo { mesh: index, name, targets, names, weights })
    };
    doc.root.meshes.iter().enumerate().filter_map(one).collect()
}

/// Names of morph targets; a convention of exporters, not of the specification.
fn target_names(extras: &json::Extras) -> Option<Vec<String>> {
    let extras: Value = serde_json::from_str(extras.as_ref()?.get()).ok()?;
    let names = extras.get("targetNames")?.as_array()?;
    Some(names.iter().map(|name| name.as_str().unwrap_or_default().to_owned()).collect())
}

/// Names of all materials; index-based for unnamed ones.
pub(super) fn materials(doc: &Document<'_>) -> Vec<String> {
    let name = |(i, m): (usize, &json::Material)| {
        own(m.name.as_deref()).unwrap_or_else(|| label("material", i, None))
    };
    doc.root.materials.iter().enumerate().map(name).collect()
}
