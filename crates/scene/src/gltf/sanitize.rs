//! Repair of common errors in files whose intended meaning is clear. They are corrected in the JSON, with a warning
//! where the file violates the specification.
use super::enumerations;
use crate::Warning;
use serde_json::{Value, json};

/// Corrects the JSON; returns whether anything was changed.
pub(super) fn sanitize(value: &mut Value, warnings: &mut Vec<Warning>) -> bool {
    let scenes = scenes_without_nodes(value);
    let enumerations = enumerations::sanitize(value, warnings);
    variants_without_names(value) || scenes || enumerations
}

/// Adds empty names to variants without a name, which KHR_materials_variants requires; they are selected by index.
fn variants_without_names(value: &mut Value) -> bool {
    let mut found = false;
    for variant in objects(value.pointer_mut("/extensions/KHR_materials_variants/variants")) {
        if !variant.contains_key("name") {
            variant.insert("name".into(), json!(""));
            found = true;
        }
    }
    found
}

/// Adds empty node lists to scenes without one, which is valid (glTF 2.0, §5.29), but which the crate `gltf` 1.4
/// rejects.
fn scenes_without_nodes(value: &mut Value) -> bool {
    let mut found = false;
    for scene in objects(value.get_mut("scenes")) {
        if !scene.contains_key("nodes") {
            scene.insert("nodes".into(), json!([]));
            found = true;
        }
    }
    found
}

fn objects(list: Option<&mut Value>) -> impl Iterator<Item = &mut serde_json::Map<String, Value>> {
    list.and_then(Value::as_array_mut).into_iter().flatten().filter_map(Value::as_object_mut)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clear_errors_are_corrected_and_others_left() {
        let mut value = json!({
            "scenes": [{}, { "nodes": [1] }],
            "animations": [{ "samplers": [{ "interpolation": 1 }, { "interpolation": "LINEAR" }, {}, { "interpolation": 9 }] }],
        });
        let mut warnings = Vec::new();
        assert!(sanitize(&mut value, &mut warnings));
        assert_eq!(value["scenes"], json!([{ "nodes": [] }, { "nodes": [1] }]));
        let samplers =
            json!([{ "interpolation": "STEP" }, { "interpolation": "LINEAR" }, {}, { "interpolation": 9 }]);
        assert_eq!(value["animations"][0]["samplers"], samplers);
        assert_eq!(warnings.len(), 1);
        assert!(!sanitize(&mut value, &mut warnings));
        for odd in [json!(null), json!({ "scenes": 3, "animations": {} }), json!({ "animations": [3] })] {
            assert!(!sanitize(&mut odd.clone(), &mut warnings));
        }
    }
}
