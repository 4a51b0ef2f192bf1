//! Warnings about unsupported features in those parts of the file that are visible.
use super::{
    choose::Selected,
    container::{self, MAX_NAMED},
    document::Document,
    extensions,
    node::Hierarchy,
};
use gltf::json::{self, animation::Property, validation::Checked};
use serde_json::Value;
use std::collections::BTreeSet;

/// Warns about extensions that affect visible parts and are neither required nor supported, and about morph targets.
pub(super) fn warn(doc: &Document<'_>, selected: &Selected, hierarchy: &Hierarchy) {
    let required: BTreeSet<&str> = container::names(&doc.value, "extensionsRequired").into_iter().collect();
    let mut used = extensions::visible(parts(doc, selected, hierarchy).into_iter());
    used.extend(extensions::of_the_whole(&doc.value));
    // The warning was issued when the file was parsed.
    used.remove(extensions::POINTER);
    let unsupported = |name: &&str| !extensions::is_supported(name) && !required.contains(name);
    let mut left_out = used.into_iter().filter(unsupported);
    for name in left_out.by_ref().take(MAX_NAMED) {
        doc.warn(extensions::left_out(name, &doc.value));
    }
    let more = left_out.count();
    if more > 0 {
        doc.warn(format!("{more} more extensions are not supported"));
    }
    warn_of_morphs(doc, selected, hierarchy);
}

/// Warns about morph targets if they would change a visible shape: if weights are not zero, or are animated.
fn warn_of_morphs(doc: &Document<'_>, selected: &Selected, hierarchy: &Hierarchy) {
    let animations = selected.animations.iter().flat_map(|&i| &doc.root.animations[i].channels);
    let is_weight =
        |c: &&json::animation::Channel| c.target.path == Checked::Valid(Property::MorphTargetWeights);
    let moved: BTreeSet<usize> = animations.filter(is_weight).map(|c| c.target.node.value()).collect();
    let changes = |node: &usize| {
        let weighted = &doc.root.nodes[*node];
        let Some(mesh) = weighted.mesh.and_then(|mesh| doc.root.meshes.get(mesh.value())) else {
            return false;
        };
        let has_targets = |p: &json::mesh::Primitive| p.targets.as_ref().is_some_and(|t| !t.is_empty());
        let mut weights = weighted.weights.as_ref().or(mesh.weights.as_ref()).into_iter().flatten();
        mesh.primitives.iter().any(has_targets) && (moved.contains(node) || weights.any(|w| *w != 0.0))
    };
    if hierarchy.order.iter().any(changes) {
        doc.warn(
            "morph targets are not applied: meshes show their base shape; bake the shape before export"
                .into(),
        );
    }
}

/// The visible parts: the scene and its nodes, their meshes with materials and textures, and all data.
fn parts<'a>(doc: &'a Document<'_>, selected: &Selected, hierarchy: &Hierarchy) -> Vec<&'a Value> {
    let value = &doc.value;
    let mut parts: Vec<&Value> = ["accessors", "bufferViews", "buffers", "cameras", "samplers", "skins"]
        .map(|list| &value[list])
        .into();
    parts.extend(selected.scene.map(|scene| &value["scenes"][scene]));
    let (mut meshes, mut materials) = (BTreeSet::new(), BTreeSet::new());
    for &node in &hierarchy.order {
        parts.push(&value["nodes"][node]);
        meshes.extend(doc.root.nodes[node].mesh.map(|mesh| mesh.value()));
        materials.extend(index(value["nodes"][node].pointer("/extras/dapple/material")));
    }
    for mesh in meshes {
        parts.push(&value["meshes"][mesh]);
        let primitives = doc.root.meshes.get(mesh).into_iter().flat_map(|mesh| &mesh.primitives);
        materials.extend(primitives.filter_map(|p| selected.material(p)).map(|material| material.value()));
    }
    let materials: Vec<&Value> = materials.into_iter().map(|i| &value["materials"][i]).collect();
    let textures: BTreeSet<usize> = materials.iter().flat_map(|material| textures(material)).collect();
    parts.extend(materials);
    for texture in textures {
        let texture = &value["textures"][texture];
        parts.push(texture);
        parts.extend(index(texture.get("source")).map(|image| &value["images"][image]));
    }
    parts
}

fn index(value: Option<&Value>) -> Option<usize> {
    value.and_then(Value::as_u64).and_then(|i| usize::try_from(i).ok())
}

/// Indices of the textures that a material references, including those of its extensions.
fn textures(material: &Value) -> Vec<usize> {
    let (mut found, mut open) = (Vec::new(), vec![material]);
    while let Some(value) = open.pop() {
        for (key, inner) in value.as_object().into_iter().flatten() {
            if key.ends_with("Texture") {
                found.extend(index(inner.get("index")));
            }
            open.extend(Some(inner).filter(|inner| inner.is_object()));
        }
    }
    found
}
