//! `--dry-run`: everything is checked and forecast before the first ray, and nothing is written.

mod dapple;

use dapple::{files, run, well};
use std::fs;

#[test]
fn a_forecast_is_close_to_the_render() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for more in [
        &["--spp", "32"][..],
        &["--method", "distribution", "--pixel", "2x2", "--light", "4", "--max-bounces", "4"],
    ] {
        let base = ["render", "--size", "48x48", "-o", "a.exr", "-o", "b.png", "--json", "--checkpoint", "c"];
        let told = well(path, &[&base[..], more, &["--dry-run"]].concat()).json();
        assert!(files(path).is_empty(), "{:?}", files(path));
        let rendered = well(path, &[&base[..], more].concat()).json();
        let ratio = told["rays"].as_f64().unwrap() / rendered["rays"].as_f64().unwrap();
        // The distribution tracer's forecast is an upper bound, because some rays leave the box.
        assert!((0.9..4.0).contains(&ratio), "{more:?}: {ratio}");
        assert_eq!(told["samples"], rendered["samples"]);
        assert!(told["render_seconds"].as_f64().unwrap() > 0.0 && told["fits"] == true);
        for file in told["files"].as_array().unwrap() {
            let name = file["path"].as_str().unwrap();
            let size = fs::metadata(path.join(name)).unwrap().len();
            assert!(size <= file["bytes_at_most"].as_u64().unwrap(), "{name}: {size}");
        }
        assert!(told["checkpoint_seconds"].as_f64().unwrap() > 0.0);
        files(path).iter().for_each(|name| fs::remove_file(path.join(name)).unwrap());
    }
}

#[test]
fn what_the_render_would_refuse_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let refused = |more: &[&str], said: &str| {
        let found = run(path, &[&["render", "--dry-run"], more].concat());
        assert!(found.code == 2 && found.err.contains(said), "{more:?}: {}", found.err);
    };
    refused(&["-o", "none/a.exr"], "none");
    refused(&["missing.gltf", "-o", "a.exr"], "missing.gltf");
    refused(&["--size", "60000x60000", "-o", "a.exr"], "--size");
    refused(&["--spp", "4", "--samples", "0:8", "-o", "a.part"], "only 4 samples");
    assert!(files(path).is_empty());
}

#[test]
fn frames_and_missing_textures_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let scene = dapple::triangle(|scene, _| {
        scene["materials"] =
            serde_json::json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        scene["textures"] = serde_json::json!([{ "source": 0 }]);
        scene["images"] = serde_json::json!([{ "uri": "none.png" }]);
        scene["meshes"][0]["primitives"][0]["material"] = 0.into();
    });
    fs::write(path.join("a.gltf"), scene).unwrap();
    let small = ["render", "a.gltf", "--size", "8x8", "--dry-run", "--json", "-o"];
    let of = |more: &[&str]| well(path, &[&small[..], more].concat()).json();
    let (one, many) = (of(&["a.exr"]), of(&["a.###.exr", "--frames", "0:10"]));
    assert!(one["warnings"].to_string().contains("none.png"), "{}", one["warnings"]);
    let needed = |told: &serde_json::Value| told["disks"][0]["needed_bytes"].as_u64().unwrap();
    assert_eq!((many["images"].as_u64(), 2 * needed(&many)), (Some(10), 11 * needed(&one)));
    assert_eq!(files(path), ["a.gltf"]);
}
