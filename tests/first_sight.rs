//! Nearly black images come with a warning that states the reason and a remedy.
#![cfg(all(feature = "gltf", feature = "exr"))]

mod dapple;

use dapple::{triangle, well};
use dapple_imaging::read;
use serde_json::json;
use std::path::Path;

/// Returns the mean of the green channel, and the messages.
fn render(folder: &Path, scene: &str, more: &[&str]) -> (f32, String) {
    std::fs::write(folder.join("a.gltf"), scene).unwrap();
    let common = ["render", "a.gltf", "--size", "24x16", "--spp", "4", "-o", "a.exr"];
    let run = well(folder, &[&common[..], more].concat());
    (read::picture(&folder.join("a.exr")).unwrap().mean().y, run.err)
}

/// The triangle and a camera that faces away from it, optionally with a lamp.
fn turned_away(has_lamp: bool) -> String {
    triangle(|root, _| {
        root["nodes"][1]["rotation"] = json!([0, 1, 0, 0]);
        if has_lamp {
            root["extensionsUsed"] = json!(["KHR_lights_punctual"]);
            root["extensions"] =
                json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 50}]}});
            root["nodes"][1]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
        }
    })
}

#[test]
fn a_camera_that_sees_no_surface_shows_the_background() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for has_lamp in [false, true] {
        let scene = turned_away(has_lamp);
        let (mean, said) = render(at, &scene, &[]);
        assert!(mean > 0.1, "{mean}");
        assert!(said.contains("camera 'eye' sees no surface") && said.contains("--orbit"), "{said}");
        assert!(said.matches("studio").count() == 1 && !said.contains("is added"), "{said}");
        let (mean, said) = render(at, &scene, &["--env", "none"]);
        assert!(mean == 0.0 && said.contains("the image is black") && !said.contains("studio"), "{said}");
        let (mean, said) = render(at, &scene, &["--env-color", "1,2,3"]);
        assert!((mean - 2.0).abs() < 1e-6 && said.contains("shows only the environment"), "{said}");
        let (mean, said) = render(at, &scene, &["--orbit", "10,20"]);
        assert!(mean > 0.01 && !said.contains("sees no surface"), "{said}");
    }
}

#[test]
fn a_scene_without_surfaces_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let empty = triangle(|root, _| root["scenes"][0]["nodes"] = json!([1]));
    let (mean, said) = render(folder.path(), &empty, &[]);
    assert!(mean > 0.1 && said.contains("the scene has no surfaces"), "{mean} {said}");
}

/// A small surface is found, even if the first rays miss it.
#[test]
fn a_speck_is_a_surface() {
    let folder = tempfile::tempdir().unwrap();
    let speck = triangle(|root, _| root["nodes"][0]["scale"] = json!([0.02, 0.02, 0.02]));
    let (_, said) = render(folder.path(), &speck, &[]);
    assert!(!said.contains("sees no surface"), "{said}");
}

/// A cube of side 4 around a camera in its centre. All walls face inwards, or all but the one in front of the camera
/// outwards.
fn cell(is_double_sided: bool, faces_in: bool) -> String {
    // Corner i is at (±2, ±2, ±2) by its bits; the walls as seen from outside, the one at −z first.
    const WALLS: [[u16; 4]; 6] =
        [[2, 3, 1, 0], [4, 5, 7, 6], [0, 1, 5, 4], [6, 7, 3, 2], [4, 6, 2, 0], [1, 3, 7, 5]];
    triangle(|root, bytes| {
        let side = |i: u16, bit: u16| if i >> bit & 1 == 1 { 2.0_f32 } else { -2.0 };
        *bytes =
            (0..8).flat_map(|i| [side(i, 0), side(i, 1), side(i, 2)]).flat_map(f32::to_le_bytes).collect();
        for (k, [a, b, c, d]) in WALLS.into_iter().enumerate() {
            let inwards = [a, c, b, a, d, c];
            let outwards = [a, b, c, a, c, d];
            let corners = if faces_in || k == 0 { inwards } else { outwards };
            bytes.extend(corners.iter().flat_map(|i| i.to_le_bytes()));
        }
        root["accessors"] = json!([
            { "bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3",
              "min": [-2, -2, -2], "max": [2, 2, 2] },
            { "bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR" },
        ]);
        root["bufferViews"] = json!([
            { "buffer": 0, "byteOffset": 0, "byteLength": 96 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 72 },
        ]);
        root["buffers"][0]["byteLength"] = 168.into();
        root["materials"] = json!([{ "doubleSided": is_double_sided }]);
        root["meshes"][0]["primitives"][0]["material"] = 0.into();
        root["nodes"][1]["translation"] = json!([0.1, 0.1, 0.1]);
    })
}

#[test]
fn a_camera_in_a_closed_space_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (scene, opens) in [(cell(true, true), false), (cell(false, true), false), (cell(false, false), true)]
    {
        for light in [&[][..], &["--env-color", "1,1,1"]] {
            let (mean, said) = render(at, &scene, light);
            assert!(mean < 1e-3, "{mean}");
            assert!(said.contains("camera 'eye' is in a closed space that no light enters"), "{said}");
            assert!(said.contains("--orbit"), "{said}");
            let is_added = said.contains("a soft studio environment is added (--env none prevents this)");
            assert_eq!(is_added, light.is_empty(), "{said}");
            assert_eq!(said.contains("--backfaces culled"), opens, "{said}");
        }
        // From outside, the camera sees through inward-facing walls to others that no light reaches.
        let (mean, said) = render(at, &scene, &["--orbit", "30,20"]);
        let is_unlit = said.contains("almost no light reaches") && said.contains("--backfaces shown");
        assert!(mean > 0.1 && !said.contains("closed space"), "{mean} {said}");
        assert!(said.contains("--env none prevents this"), "{is_unlit} {said}");
        let (_, said) = render(at, &scene, &["--orbit", "30,20", "--backfaces", "shown"]);
        assert!(said.contains("studio") && !said.contains("almost no light"), "{said}");
    }
    let (mean, said) = render(at, &cell(false, false), &["--backfaces", "culled"]);
    assert!(mean > 0.1 && !said.contains("closed space"), "{mean} {said}");
}

/// The triangle, of a material in JSON.
fn of_material(material: &serde_json::Value) -> String {
    triangle(|root, _| {
        root["materials"] = json!([material]);
        root["meshes"][0]["primitives"][0]["material"] = 0.into();
    })
}

const STUDIO: &str = "a soft studio environment is added (--env none prevents this)";

#[test]
fn black_surfaces_are_named_as_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let black = of_material(&json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
        "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
    }));
    let (_, said) = render(folder.path(), &black, &[]);
    assert!(said.contains("the surfaces that camera 'eye' sees reflect almost no light"), "{said}");
    assert!(said.contains(STUDIO), "{said}");
    let info = well(folder.path(), &["info", "a.gltf"]).out;
    assert!(info.contains("reflect almost no light") && info.contains(STUDIO), "{info}");
}

/// Black metal reflects some light at grazing angles. Where it fills the image, the metered exposure shows it.
#[test]
fn black_metal_that_is_visible_is_not_called_black() {
    let folder = tempfile::tempdir().unwrap();
    let metal = json!({"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 1}});
    let near = ["--look-from", "0,-0.3,0.3", "--look-at", "0,-0.3,0"];
    let (_, said) = render(folder.path(), &of_material(&metal), &[&near[..], &["-o", "a.png"]].concat());
    let image = read::picture(&folder.path().join("a.png")).unwrap();
    assert!(image.mean().y > 0.1, "{}", image.mean());
    assert!(said.contains(STUDIO) && !said.contains("black"), "{said}");
}

#[test]
fn a_scene_without_light_that_stays_dark_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (option, value, why) in [
        ("--env", "none", "--env none prevents the default light"),
        ("--env-color", "0,0,0", "the environment that is given is black"),
    ] {
        let (mean, said) = render(at, &triangle(|_, _| {}), &[option, value]);
        assert_eq!(mean, 0.0);
        let line = format!("nothing in the scene emits light, and {why}: the image is black");
        assert!(said.contains(&line), "{said}");
        assert!(well(at, &["info", "a.gltf", option, value]).out.contains(&line));
        let unlit = of_material(&json!({"extensions": {"KHR_materials_unlit": {}}}));
        let (mean, said) = render(at, &unlit, &[option, value]);
        assert!(mean > 0.03 && !said.contains("emits light"), "{said}");
    }
}

/// A single-sided triangle seen from behind, also from other directions behind it.
#[test]
fn culled_back_faces_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let behind = triangle(|root, _| {
        root["nodes"][1]["translation"] = json!([0, 0, -4]);
        root["nodes"][1]["rotation"] = json!([0, 1, 0, 0]);
    });
    for more in [&[][..], &["--orbit", "190,20"]] {
        let (_, said) = render(folder.path(), &behind, more);
        assert!(said.contains("only back faces") && said.contains("--backfaces shown"), "{said}");
        assert!(!said.contains("--orbit"), "{said}");
        let (_, said) = render(folder.path(), &behind, &[more, &["--backfaces", "shown"]].concat());
        assert!(!said.contains("back faces"), "{said}");
    }
}
