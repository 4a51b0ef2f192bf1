//! Supported glTF extensions, and the visible effect of unsupported optional ones.

use crate::error::quoted;
use serde_json::Value;
use std::collections::BTreeSet;

pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
const IMAGE_BASED: &str = "EXT_lights_image_based";
const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";
/// The channels of this extension are removed from the JSON when it is parsed.
pub(super) const POINTER: &str = "KHR_animation_pointer";
const BASISU: &str = "KHR_texture_basisu";

/// Extensions that a file may require.
pub(super) const SUPPORTED: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Effect on the image of extensions that are used but neither required nor supported.
const LEFT_OUT: &[(&str, &str)] = &[
    (IMAGE_BASED, "its environment is left out (--env sets one)"),
    (MESHOPT[0], "the uncompressed copy of the data is used"),
    (POINTER, "animated properties of materials, lights and cameras keep their initial values"),
    (DRACO, "the uncompressed copy of the meshes is used"),
    ("KHR_materials_anisotropy", "anisotropic highlights are rendered as isotropic"),
    ("KHR_materials_clearcoat", "clear coats are left out"),
    ("KHR_materials_diffuse_transmission", "diffuse transmission is left out"),
    ("KHR_materials_dispersion", "glass shows no dispersion"),
    ("KHR_materials_iridescence", "thin-film interference is left out"),
    (SPECULAR_GLOSSINESS, "the metallic-roughness values are used"),
    ("KHR_materials_sheen", "sheen is left out"),
    (MESHOPT[1], "the uncompressed copy of the data is used"),
    (BASISU, "the textures' PNG or JPEG copies are used"),
];

/// Extensions without effect on the image: metadata, sound, physics, interaction, and alternative levels of detail.
const INVISIBLE: &[&str] = &[
    "AGI_stk_metadata",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "GODOT_single_root",
    "KHR_audio",
    "KHR_audio_emitter",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MOZ_hubs_components",
    "MSFT_audio_emitter",
    "MSFT_lod",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
    "OMI_physics_body",
    "OMI_physics_joint",
    "OMI_physics_shape",
    "VRMC_springBone",
];

/// Material extensions that have no effect if this factor is zero, which is its default.
const BY_FACTOR: &[(&str, &str)] = &[
    ("KHR_materials_anisotropy", "anisotropyStrength"),
    ("KHR_materials_clearcoat", "clearcoatFactor"),
    ("KHR_materials_diffuse_transmission", "diffuseTransmissionFactor"),
    ("KHR_materials_dispersion", "dispersion"),
    ("KHR_materials_iridescence", "iridescenceFactor"),
    ("KHR_materials_sheen", "sheenColorFactor"),
    ("KHR_materials_volume_scatter", "multiscatterColor"),
];

pub(super) fn is_supported(name: &str) -> bool {
    SUPPORTED.contains(&name)
}

/// The warning for an extension that is used but neither required nor supported.
pub(super) fn left_out(name: &str, value: &Value) -> String {
    let effect = LEFT_OUT.iter().find(|(n, _)| *n == name).map_or("its effect is left out", |(_, e)| e);
    let effect = without_copy(name, value).unwrap_or(effect);
    format!("{} is not supported: {effect}", quoted(name))
}

/// Whether an extension object has no effect on the image.
fn is_neutral(name: &str, object: &Value) -> bool {
    let is_zero = |v: &Value| v.as_f64() == Some(0.0);
    INVISIBLE.contains(&name)
        || BY_FACTOR.iter().any(|(n, factor)| {
            *n == name
                && match object.get(factor) {
                    None => true,
                    Some(Value::Array(factors)) => factors.iter().all(is_zero),
                    Some(factor) => is_zero(factor),
                }
        })
}

/// Effect of an unsupported extension if the file has no fallback for it.
fn without_copy(name: &str, value: &Value) -> Option<&'static str> {
    let extended = |list: &str| objects(value, list).filter(|o| o["extensions"].get(name).is_some());
    match name {
        DRACO => {
            let primitives = objects(value, "meshes").flat_map(|mesh| objects(mesh, "primitives"));
            let compressed = |p: &&Value| p["extensions"].get(name).is_some();
            let lacks_data = |p: &Value| {
                let accessor = p["attributes"]["POSITION"].as_u64().and_then(|i| usize::try_from(i).ok());
                accessor.is_none_or(|i| value["accessors"][i].get("bufferView").is_none())
            };
            let lacking = primitives.filter(compressed).any(lacks_data);
            lacking.then_some("meshes that have no uncompressed copy are left out")
        }
        SPECULAR_GLOSSINESS => {
            let lacking = extended("materials").any(|m| m.get("pbrMetallicRoughness").is_none());
            lacking.then_some(
                "materials without metallic-roughness values get glTF's default, a rough white metal",
            )
        }
        BASISU => {
            let lacking = extended("textures").any(|t| t.get("source").is_none());
            lacking.then_some("textures that have no PNG or JPEG copy are left out")
        }
        _ => None,
    }
}

fn objects<'a>(value: &'a Value, list: &str) -> impl Iterator<Item = &'a Value> + use<'a> {
    value.get(list).and_then(Value::as_array).into_iter().flatten()
}

/// Extensions that the file actually uses, declared or not: the keys of all objects named `extensions`.
pub(super) fn used(value: &Value) -> BTreeSet<&str> {
    let mut found = BTreeSet::new();
    walk(value, &mut |name, _| {
        found.insert(name);
    });
    found
}

/// Extensions in these parts of the file that affect the image.
pub(super) fn visible<'a>(parts: impl Iterator<Item = &'a Value>) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::new();
    for part in parts {
        walk(part, &mut |name, object| {
            if !is_neutral(name, object) {
                found.insert(name);
            }
        });
    }
    found
}

/// Extensions at the top level of the file that affect the image. [`IMAGE_BASED`] is excluded: scenes refer to it.
pub(super) fn of_the_whole(value: &Value) -> impl Iterator<Item = &str> {
    let all = value.get("extensions").and_then(Value::as_object).into_iter().flatten();
    all.filter(|(name, object)| *name != IMAGE_BASED && !is_neutral(name, object))
        .map(|(name, _)| name.as_str())
}

/// Calls `found` with the name of every extension and its object. JSON nests at most 128 levels deep.
fn walk<'a>(value: &'a Value, found: &mut dyn FnMut(&'a str, &'a Value)) {
    let mut open = vec![value];
    while let Some(value) = open.pop() {
        match value {
            Value::Array(items) => open.extend(items.iter().filter(|v| v.is_array() || v.is_object())),
            Value::Object(map) => {
                if let Some(Value::Object(extensions)) = map.get("extensions") {
                    extensions.iter().for_each(|(name, object)| found(name, object));
                }
                // Extras belong to the application.
                let inside =
                    map.iter().filter(|(key, v)| *key != "extras" && (v.is_array() || v.is_object()));
                open.extend(inside.map(|(_, v)| v));
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn used_is_what_stands_in_the_file() {
        let value = json!({
            "extensionsUsed": ["A_declared"],
            "extensions": { "B_root": {} },
            "materials": [{ "extensions": { "C_material": { "t": { "index": 0, "extensions": { "D_inner": {} } } } },
                            "extras": { "extensions": { "E_extras": {} } } }],
        });
        assert_eq!(used(&value).into_iter().collect::<Vec<_>>(), ["B_root", "C_material", "D_inner"]);
    }

    #[test]
    fn copies_are_promised_only_where_there_are_some() {
        let draco = |accessor: Value| {
            let primitive = json!({ "attributes": { "POSITION": 0 }, "extensions": { DRACO: {} } });
            let value = json!({ "meshes": [{ "primitives": [primitive] }], "accessors": [accessor] });
            left_out(DRACO, &value)
        };
        assert!(draco(json!({ "bufferView": 0 })).contains("uncompressed copy of the meshes is used"));
        assert!(draco(json!({})).contains("are left out"));
        let material = |beside: bool| {
            let mut material = json!({ "extensions": { SPECULAR_GLOSSINESS: {} } });
            if beside {
                material["pbrMetallicRoughness"] = json!({});
            }
            left_out(SPECULAR_GLOSSINESS, &json!({ "materials": [material] }))
        };
        assert!(material(true).contains("values are used") && material(false).contains("default"));
    }

    #[test]
    fn objects_that_change_nothing_are_invisible() {
        let parts = [
            json!({ "extensions": { "KHR_materials_clearcoat": { "clearcoatRoughnessFactor": 1 }, "MSFT_lod": { "ids": [1] } } }),
            json!({ "extensions": { "KHR_materials_sheen": { "sheenColorFactor": [0, 0.0, 0] }, "KHR_materials_dispersion": {} } }),
            json!({ "extensions": { "KHR_materials_anisotropy": { "anisotropyStrength": 0 } } }),
        ];
        assert!(visible(parts.iter()).is_empty());
        let parts = [
            json!({ "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 0.1 } } }),
            json!({ "extensions": { "KHR_materials_sheen": { "sheenColorFactor": [0, 0, 1] }, "VENDOR_x": {} } }),
        ];
        let found: Vec<&str> = visible(parts.iter()).into_iter().collect();
        assert_eq!(found, ["KHR_materials_clearcoat", "KHR_materials_sheen", "VENDOR_x"]);
    }
}
