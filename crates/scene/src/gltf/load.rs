//! Estimate of the memory that a file's scene takes once all instances are placed, from the JSON alone.
use super::{
    document::Document,
    instancing, mesh,
    node::{self, Hierarchy},
};
use crate::{SceneError, memory::Load};
use gltf::json::{self, mesh::Semantic, validation::Checked};

/// Number of animated ancestors per object that is always accepted.
const SHALLOW: u64 = 64;
/// Limit of the links beyond [`SHALLOW`] per object in a scene: all of them are evaluated whenever the placements of
/// its objects are needed.
const MOST_DEEP: u64 = 1 << 20;

/// The load of everything that a scene places, without textures.
pub(super) fn load(doc: &Document<'_>, hierarchy: &Hierarchy) -> Load {
    every(doc, hierarchy).map(|(_, load)| load).fold(Load::default(), Load::plus)
}

/// Returns an error if the scene needs more memory than is available.
pub(super) fn check(doc: &Document<'_>, hierarchy: &Hierarchy) -> Result<(), SceneError> {
    let (mut all, mut most) = (Load::default(), (0, Load::default()));
    let mut deep = 0_u64;
    for (index, load) in every(doc, hierarchy) {
        all = all.plus(load);
        deep = deep.saturating_add(load.links.saturating_sub(load.objects.max(1).saturating_mul(SHALLOW)));
        if deep > MOST_DEEP {
            let what = "has too many animated ancestors: more than a million transforms would have to be evaluated at \
                        every instant; animate fewer nodes";
            return Err(doc.invalid(node::place(doc, index), what));
        }
        if load.peak_bytes() > most.1.peak_bytes() {
            most = (index, load);
        }
    }
    all.admit(doc.options.memory, doc.whole_length()).map_err(|overrun| {
        let (index, node) = most;
        let of = doc.root.nodes.get(index).map_or_else(String::new, |_| node::place(doc, index));
        let place = format!(
            "the scene with its {} triangles in {} objects ({} and {} of them in {of})",
            all.triangles, all.objects, node.triangles, node.objects
        );
        SceneError::Memory { file: doc.file.clone(), place, overrun }
    })
}

/// The load of each visible node, with the node's index. Each mesh is evaluated once.
fn every<'a>(
    doc: &'a Document<'_>,
    hierarchy: &'a Hierarchy,
) -> impl Iterator<Item = (usize, Load)> + use<'a> {
    let mut known: Vec<Option<Load>> = vec![None; doc.root.meshes.len()];
    let moving = hierarchy.links(doc.options);
    hierarchy.order.iter().map(move |&index| {
        let node = &doc.root.nodes[index];
        let mut load = Load::default();
        if let Some(mesh) = node.mesh.map(|mesh| mesh.value()).filter(|mesh| *mesh < known.len()) {
            let one = *known[mesh].get_or_insert_with(|| of_mesh(doc, &doc.root.meshes[mesh]));
            load = one.times(instancing::count(doc, index).ok().flatten().unwrap_or(1));
        }
        let hangs = u64::from(node.camera.is_some() || node.extensions.is_some());
        load.links = load.objects.saturating_add(hangs).saturating_mul(moving[index]);
        (index, load)
    })
}

fn of_mesh(doc: &Document<'_>, mesh: &json::Mesh) -> Load {
    let one = |primitive: &json::mesh::Primitive| {
        let count = |semantic| {
            let accessor = primitive.attributes.get(&Checked::Valid(semantic))?;
            Some(doc.root.accessors.get(accessor.value())?.count.0)
        };
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let positions = positions.and_then(|accessor| doc.root.accessors.get(accessor.value()));
        // Without data all vertices coincide: no triangle remains.
        let Some(_) = positions.filter(|p| p.buffer_view.is_some() || p.sparse.is_some()) else {
            return Load::default();
        };
        let triangles = mesh::triangle_count(doc, primitive, "").unwrap_or(0);
        // Unused vertices are not kept.
        let used = |count: Option<u64>| count.unwrap_or(0).min(triangles.saturating_mul(3));
        let more = [
            (Semantic::Normals, 3),
            (Semantic::Tangents, 4),
            (Semantic::TexCoords(0), 2),
            (Semantic::TexCoords(1), 2),
            (Semantic::Colors(0), 4),
        ];
        let attributes = more.map(|(semantic, n)| used(count(semantic)).saturating_mul(n));
        Load {
            triangles,
            vertices: used(count(Semantic::Positions)),
            attributes: attributes.into_iter().fold(0, u64::saturating_add),
            objects: u64::from(triangles > 0),
            ..Load::default()
        }
    };
    mesh.primitives.iter().map(one).fold(Load::default(), Load::plus)
}
