//! Only the images and channels that the render uses are decoded.
#![cfg(feature = "gltf")]
mod file;

use base64::Engine;
use dapple_imaging::{Image, Tone, write};
use dapple_scene::{Reads, Scene, gltf};
use file::{File, json};
use std::path::Path;

/// A PNG image in which all channels differ.
fn png() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let color = |i: usize| glam::Vec3::new(0.1, 0.2, 0.4) * (1.0 + i as f32);
    let picture = Image { width: 2, height: 1, pixels: (0..2).map(color).collect() };
    write::png(&path, &picture, Tone::Srgb, 0.0).unwrap();
    std::fs::read(path).unwrap()
}

/// A square with five images, one for each texture of the core specification.
fn painted(alpha_mode: &str) -> Vec<u8> {
    let mut file = File::new();
    let positions = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0_f32]]);
    let uv = file.floats(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0_f32]]);
    let indices = file.indices_u16(&[0, 1, 2, 0, 2, 3]);
    let uri = format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(png()));
    file.set("images", json!(vec![json!({ "uri": uri }); 5]));
    file.set("textures", (0..5).map(|i| json!({ "source": i })).collect());
    file.set(
        "materials",
        json!([{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}},
            "normalTexture": {"index": 2}, "occlusionTexture": {"index": 3},
            "emissiveTexture": {"index": 4}, "emissiveFactor": [1, 1, 1], "alphaMode": alpha_mode,
        }]),
    );
    let attributes = json!({"POSITION": positions, "TEXCOORD_0": uv});
    file.set(
        "meshes",
        json!([{"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}]),
    );
    file.set("nodes", json!([{"mesh": 0}]));
    file.gltf()
}

fn load(alpha_mode: &str, reads: Reads) -> Scene {
    let options = gltf::Options { reads, ..gltf::Options::default() };
    gltf::read_bytes(Path::new("test.gltf"), &painted(alpha_mode), &options).unwrap().build().unwrap()
}

fn channels(scene: &Scene) -> Vec<usize> {
    scene.textures.iter().map(|t| t.channels()).collect()
}

const FIRST_HITS: Reads =
    Reads { light: false, scattering: false, albedo: false, normals: false, everything: false };

#[test]
fn where_light_is_scattered_all_but_occlusion_is_decoded() {
    let scene = load("OPAQUE", Reads::default());
    assert_eq!((channels(&scene), scene.survey.unread.images), (vec![3, 2, 3, 3], 1));
    assert_eq!(scene.survey.dropped_channels, 5);
    assert_eq!(channels(&load("OPAQUE", Reads::EVERYTHING)), [4; 4]);
}

#[test]
fn emitters_seen_directly_take_their_image_alone() {
    let scene = load("OPAQUE", Reads { light: true, ..FIRST_HITS });
    assert_eq!((channels(&scene), scene.survey.unread.images), (vec![3], 4));
    assert!(!scene.lights.is_empty());
}

#[test]
fn first_hits_take_no_image_and_no_light() {
    let scene = load("OPAQUE", FIRST_HITS);
    assert_eq!((channels(&scene), scene.survey.unread.images), (vec![], 5));
    assert!(scene.lights.is_empty() && scene.warnings.is_empty(), "{:?}", scene.warnings);
}

/// Alpha is 1 everywhere in the image, so no channel is kept.
#[test]
fn holes_are_looked_for() {
    let scene = load("MASK", FIRST_HITS);
    assert_eq!((channels(&scene), scene.survey.unread.images), (vec![0], 4));
    assert!(!scene.has_alpha());
}

/// Ten images that share a buffer view, or a file, are decoded once.
#[test]
fn images_of_one_source_are_one() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.png"), png()).unwrap();
    for (image, from_file) in [(json!({ "uri": "a.png" }), true), (json!(null), false)] {
        let mut file = File::new();
        let positions = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0_f32]]);
        let uv = file.floats(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0_f32]]);
        let indices = file.indices_u16(&[0, 1, 2]);
        let view = file.view(&png(), None);
        let embedded = json!({ "bufferView": view, "mimeType": "image/png" });
        file.set("images", json!(vec![if from_file { image } else { embedded }; 10]));
        file.set("textures", (0..10).map(|i| json!({ "source": i })).collect());
        let material = |i: usize| json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": i } } });
        file.set("materials", (0..10).map(material).collect());
        let primitive = |i: usize| json!({ "attributes": { "POSITION": positions, "TEXCOORD_0": uv }, "indices": indices, "material": i });
        file.set("meshes", json!([{ "primitives": (0..10).map(primitive).collect::<Vec<_>>() }]));
        file.set("nodes", json!([{ "mesh": 0 }]));
        let path = folder.path().join("test.gltf");
        let scene =
            gltf::read_bytes(&path, &file.gltf(), &gltf::Options::default()).unwrap().build().unwrap();
        assert_eq!(scene.textures.len(), 1, "from a file: {from_file}");
    }
}
