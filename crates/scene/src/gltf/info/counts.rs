//! Counts of the items in a file.
use super::super::{document::Document, node::Hierarchy};
use serde::Serialize;

/// Counts of the items in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Counts {
    /// Nodes in the file.
    pub nodes: usize,
    /// Visible nodes of the selected scene.
    pub visible_nodes: usize,
    /// Meshes in the file.
    pub meshes: usize,
    /// Triangles of the selected scene; those of a mesh count once per instance.
    pub triangles: u64,
    /// Triangles of the meshes of the selected scene; each mesh counts once.
    pub stored_triangles: u64,
    /// Instances of meshes.
    pub instances: u64,
    /// Exact spheres and disks of the selected scene.
    pub shapes: usize,
    /// Vertices of the selected scene, counted per instance like `triangles`.
    pub vertices: u64,
    /// Materials in the file.
    pub materials: usize,
    /// Skins in the file (not applied).
    pub skins: usize,
    /// Primitives with morph targets (not applied).
    pub morphed: usize,
}

/// The counts that follow from the lists of the file and the hierarchy; those of placed objects are added later.
pub(super) fn counts(doc: &Document<'_>, hierarchy: &Hierarchy) -> Counts {
    let root = &doc.root;
    let primitives = root.meshes.iter().flat_map(|m| &m.primitives);
    Counts {
        nodes: root.nodes.len(),
        visible_nodes: hierarchy.order.len(),
        meshes: root.meshes.len(),
        materials: root.materials.len(),
        skins: root.skins.len(),
        morphed: primitives.filter(|p| p.targets.as_ref().is_some_and(|t| !t.is_empty())).count(),
        ..Counts::default()
    }
}
