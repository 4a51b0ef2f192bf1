//! Frame sequences: every frame has the bytes that it has alone, and what does not change is kept.

mod dapple;

use dapple::{files, run, scene, well};
use std::fs;
use std::path::Path;

const SMALL: [&str; 6] = ["--size", "24x16", "--spp", "4", "--quiet", "--json"];

/// Renders frames of a scene that moves.
fn frames(folder: &Path, more: &[&str]) -> serde_json::Value {
    let moving = scene("motion_blur.gltf").display().to_string();
    let out = ["-o", "a.###.exr", "-o", "a.###.png"];
    well(folder, &[&["render", &moving], &SMALL[..], &out, more].concat()).json()
}

fn bytes(folder: &Path, names: &[&str]) -> Vec<Vec<u8>> {
    names.iter().map(|name| fs::read(folder.join(name)).unwrap()).collect()
}

/// Alone, in a range, and rendered by the time and the seed that the report states.
#[test]
fn a_frame_does_not_depend_on_the_range() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let all = frames(path, &["--frames", "-1:6:3", "--fps", "10", "--shutter-angle", "180", "--seed", "5"]);
    let numbers: Vec<i64> =
        all["frames"].as_array().unwrap().iter().map(|f| f["frame"].as_i64().unwrap()).collect();
    assert_eq!(numbers, [-1, 2, 5]);
    assert_eq!(files(path), ["a.-01.exr", "a.-01.png", "a.002.exr", "a.002.png", "a.005.exr", "a.005.png"]);
    let names = ["a.002.exr", "a.002.png"];
    let first = bytes(path, &names);
    assert_ne!(first[0], bytes(path, &["a.005.exr"])[0]);
    frames(
        path,
        &["--frames", "2:3", "--fps", "10", "--shutter-angle", "180", "--seed", "5", "--threads", "1"],
    );
    assert!(bytes(path, &names) == first);
    let report = &all["frames"][1];
    let moving = scene("motion_blur.gltf").display().to_string();
    let (seed, exposure) = (report["seed"].to_string(), report["exposure"].to_string());
    let alone =
        ["render", &moving, "--at", "0.2", "--shutter", "0:0.05", "--seed", &seed, "--exposure", &exposure];
    well(path, &[&alone[..], &SMALL, &["-o", "b.exr", "-o", "b.png"]].concat());
    assert!(bytes(path, &["b.exr", "b.png"]) == first);
}

#[test]
fn existing_frames_are_skipped_and_a_fixed_seed_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    frames(path, &["--frames", "0:2", "--fixed-seed"]);
    let kept = bytes(path, &["a.000.exr"]);
    fs::write(path.join("a.000.png"), "kept").unwrap();
    let next = frames(path, &["--frames", "0:3", "--fixed-seed", "--skip-existing", "--seed", "4"]);
    assert_eq!(next["skipped"], serde_json::json!([0, 1]));
    assert_eq!((&next["frames"][0]["frame"], &next["frames"][0]["seed"]), (&2.into(), &4.into()));
    assert!(bytes(path, &["a.000.exr"]) == kept && fs::read(path.join("a.000.png")).unwrap() == b"kept");
}

/// A scene without animation is loaded once, and its frames differ by their seeds only.
#[test]
fn a_scene_that_does_not_change_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let still = scene("normal_maps.gltf").display().to_string();
    let base = [&["render", &still, "-o", "a.#.exr"], &SMALL[..]].concat();
    let all = well(path, &[&base[..], &["--frames", "0:3"]].concat()).json();
    assert!(all["saved_seconds"].as_f64().unwrap() > 0.0, "{all}");
    assert!(all["frames"][1]["load_seconds"] == 0.0 && all["frames"][0]["load_seconds"] != 0.0);
    let second = bytes(path, &["a.1.exr"]);
    well(path, &[&base[..], &["--frames", "1:2"]].concat());
    assert!(bytes(path, &["a.1.exr"]) == second && bytes(path, &["a.0.exr"]) != second);
}

#[test]
fn wrong_frames_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, said) in [
        (&["--frames", "0:2", "-o", "a.exr"][..], "write #### where its number belongs"),
        (&["--frames", "0:2", "--checkpoint", "c"], "--checkpoint c: every frame needs a file of its own"),
        (&["--frames", "2:2"], "there are no frames"),
        (&["--frames", "0:2", "--fps", "0"], "--fps"),
        (&["--frames", "0:2", "--shutter", "0:1", "--shutter-angle", "90"], "--shutter-angle"),
    ] {
        let found = run(folder.path(), &[&["render", "builtin:cornell"], arguments].concat());
        assert!(found.code == 2 && found.err.contains(said), "{arguments:?}: {}", found.err);
    }
    assert!(files(folder.path()).is_empty());
}
