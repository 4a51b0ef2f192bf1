//! Renders of first-hit layers alone compute no lighting: no image is rendered, no texture decoded, no environment
//! read.

mod dapple;

use dapple::{files, run, triangle, well};
use dapple_imaging::{Layers, read};
use std::path::Path;

/// A red and a green texel.
const PNG: &str = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAADklEQVR4nGP4z8DwHwQBEPgD/U6VwW8AAAAASUVORK5CYII=";

/// A triangle whose material uses two images.
fn painted() -> String {
    triangle(|root, bytes| {
        bytes.extend([0.0_f32, 0.0, 1.0, 0.0, 0.0, 1.0].iter().flat_map(|x| x.to_le_bytes()));
        bytes.splice(42..42, [0, 0]);
        let length = bytes.len();
        root["buffers"][0]["byteLength"] = length.into();
        let views = root["bufferViews"].as_array_mut().unwrap();
        views.push(serde_json::json!({"buffer": 0, "byteOffset": 44, "byteLength": 24}));
        let accessors = root["accessors"].as_array_mut().unwrap();
        accessors
            .push(serde_json::json!({"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"}));
        root["images"] = serde_json::json!([{ "uri": PNG }, { "uri": PNG }]);
        root["textures"] = serde_json::json!([{ "source": 0 }, { "source": 1 }]);
        root["materials"] = serde_json::json!([{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "emissiveTexture": {"index": 1}, "emissiveFactor": [1, 1, 1],
        }]);
        root["meshes"][0]["primitives"][0]["material"] = 0.into();
        root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = 2.into();
    })
}

const COMMON: [&str; 7] = ["a.gltf", "--env-color", "1,1,1", "--size", "20x14", "--spp", "4"];

fn render(folder: &Path, more: &[&str]) -> dapple::Run {
    std::fs::write(folder.join("a.gltf"), painted()).unwrap();
    well(folder, &[&["render"], &COMMON[..], more].concat())
}

fn layers(folder: &Path, more: &[&str]) -> Layers {
    render(folder, &[more, &["-o", "out.exr"]].concat());
    read::layers(&folder.join("out.exr")).unwrap()
}

fn names(layers: &Layers) -> Vec<&str> {
    layers.layers.iter().map(|l| l.name.as_str()).collect()
}

#[test]
fn depth_is_the_same_with_and_without_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    for method in ["path", "distribution"] {
        let more = ["--method", method, "--pixel", "3"];
        let alone = layers(folder.path(), &[&more[..], &["--aov", "depth"]].concat());
        let both = layers(folder.path(), &[&more[..], &["--aov", "beauty,depth"]].concat());
        assert_eq!((names(&alone), names(&both)), (vec!["depth"], vec!["", "depth"]));
        assert!(alone.layers[0].channels == both.layers[1].channels, "{method}");
        let hit = alone.layers[0].channels[0].1.iter().filter(|z| z.is_finite()).count();
        assert!(hit > 20, "{hit}");
    }
}

#[test]
fn the_plan_says_that_no_image_is_decoded() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.gltf"), painted()).unwrap();
    let left_out = |more: &[&str]| {
        let run = well(folder.path(), &[&["plan"], &COMMON[..], more].concat());
        run.out
    };
    let alone = left_out(&["--max-bounces", "0", "--aov", "depth"]);
    assert!(
        alone.contains("2 images, not decoded") && alone.contains("image and light transport"),
        "{alone}"
    );
    let seen = left_out(&["--max-bounces", "0", "--aov", "beauty,depth"]);
    assert!(seen.contains("1 images, not decoded") && !seen.contains("image and light"), "{seen}");
}

#[test]
fn what_shows_the_picture_asks_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let run = render(folder.path(), &["--aov", "depth"]);
    assert!(run.err.contains("the image itself is not rendered"), "{}", run.err);
    assert_eq!(files(folder.path()), ["a.exr", "a.gltf"]);
    assert_eq!(names(&layers(folder.path(), &["--aov", "depth", "-o", "b.png"])), ["", "depth"]);
    assert_eq!(names(&layers(folder.path(), &["--aov", "depth,variance"])), ["", "depth", "variance"]);
    assert_eq!(names(&layers(folder.path(), &["--aov", "beauty"])), [""]);
    assert_eq!(names(&layers(folder.path(), &[])), [""]);
}

/// A missing environment map is not an error if it is not needed.
#[test]
fn no_environment_is_read() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.gltf"), painted()).unwrap();
    let of = |aov: &str| {
        run(
            folder.path(),
            &["render", "a.gltf", "--env", "none.hdr", "--aov", aov, "-o", "a.exr", "--size", "8x8"],
        )
    };
    assert_eq!((of("depth,normal").code, of("beauty,depth").code), (0, 2));
}
