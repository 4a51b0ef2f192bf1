//! Instances of a mesh by EXT_mesh_gpu_instancing.
use super::{document::Document, node};
use crate::{Placement, SceneError};
use glam::{DQuat, DVec3, DVec4};
use gltf::json::{self, Index};
use serde_json::Value;

/// Maximum number of instances of a node whose attributes have no data: they all coincide.
const ZEROS: u64 = 1 << 16;
const NAME: &str = "EXT_mesh_gpu_instancing";
const ATTRIBUTES: [&str; 3] = ["TRANSLATION", "ROTATION", "SCALE"];

/// Placements of a node's instances in the node's own space; None if the node lacks the extension.
pub(super) fn placements(doc: &Document<'_>, index: usize) -> Result<Option<Vec<Placement>>, SceneError> {
    let extensions = doc.root.nodes[index].extensions.as_ref();
    let Some(instancing) = extensions.and_then(|e| e.others.get(NAME)) else {
        return Ok(None);
    };
    let place = node::place(doc, index);
    let attribute = |name: &str| attribute(instancing, name);
    let accessors = || ATTRIBUTES.iter().filter_map(|name| doc.root.accessors.get(attribute(name)?.value()));
    let instances = count(doc, index)?.unwrap_or(1);
    if instances > ZEROS && accessors().all(|accessor| accessor.buffer_view.is_none()) {
        let what = format!("has {instances} instances without data; a node may have at most {ZEROS}");
        return Err(doc.invalid(place, what));
    }
    let translations = attribute("TRANSLATION").map(|i| doc.vectors::<3>(i, &place)).transpose()?;
    let rotations = attribute("ROTATION").map(|i| doc.vectors::<4>(i, &place)).transpose()?;
    let scales = attribute("SCALE").map(|i| doc.vectors::<3>(i, &place)).transpose()?;
    let lengths: Vec<usize> = [
        translations.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
    ]
    .into_iter()
    .flatten()
    .collect();
    let count = lengths.first().copied().unwrap_or(0);
    if lengths.iter().any(|&n| n != count) {
        return Err(doc.invalid(place, format!("has instance attributes of unequal lengths: {lengths:?}")));
    }
    let vector = |all: &Option<Vec<[f32; 3]>>, i: usize, default: DVec3| {
        all.as_ref().map_or(default, |all| DVec3::from_array(all[i].map(f64::from)))
    };
    let rotation = |i: usize| {
        rotations.as_ref().map_or(DQuat::IDENTITY, |all| {
            DQuat::from_vec4(DVec4::from_array(all[i].map(f64::from)).normalize_or(DVec4::W))
        })
    };
    let one =
        |i| node::trs(vector(&translations, i, DVec3::ZERO), rotation(i), vector(&scales, i, DVec3::ONE));
    Ok(Some((0..count).map(one).collect()))
}

/// Number of instances of a node, from the JSON alone; None if the node lacks the extension.
pub(super) fn count(doc: &Document<'_>, index: usize) -> Result<Option<u64>, SceneError> {
    let extensions = doc.root.nodes[index].extensions.as_ref();
    let Some(instancing) = extensions.and_then(|e| e.others.get(NAME)) else { return Ok(None) };
    let first = ["TRANSLATION", "ROTATION", "SCALE"].iter().find_map(|name| attribute(instancing, name));
    first.map_or(Ok(Some(0)), |first| doc.count(first, &node::place(doc, index)).map(Some))
}

/// The accessor of an instance attribute.
fn attribute(instancing: &Value, name: &str) -> Option<Index<json::Accessor>> {
    let index = instancing.get("attributes")?.get(name).and_then(Value::as_u64)?;
    Some(Index::new(u32::try_from(index).unwrap_or(u32::MAX)))
}
