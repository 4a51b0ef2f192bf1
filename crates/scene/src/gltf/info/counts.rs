//! How many of everything there are in a file.
use super::super::{document::Document, node::Hierarchy};
use serde::Serialize;

/// How many of everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Counts {
    /// Nodes in the file.
    pub nodes: usize,
    /// Nodes the scene shows.
    pub visible_nodes: usize,
    /// Meshes in the file.
    pub meshes: usize,
    /// Triangles the scene shows: those of a mesh once for every place where it stands.
    pub triangles: u64,
    /// Triangles of the meshes that the scene shows, each counted once.
    pub stored_triangles: u64,
    /// Places where meshes stand.
    pub instances: u64,
    /// Exact spheres and disks the scene shows.
    pub shapes: usize,
    /// Vertices the scene shows, counted like the triangles.
    pub vertices: u64,
    /// Materials in the file.
    pub materials: usize,
    /// Skins in the file (not applied).
    pub skins: usize,
    /// Primitives with morph targets (not applied).
    pub morphed: usize,
}

/// What the lists of the file and the hierarchy tell; what is placed is counted later.
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
