//! Scenes in which nothing shares a place ask nothing: what stands on a floor is none.
#![cfg(feature = "gltf")]

use dapple_scene::gltf;
use std::path::Path;

/// Lamps in lamps or in walls, and clear matter on a floor.
const SHARED: [&str; 4] = ["coincident", "coplanar", "cornell_spheres", "furnace"];

#[test]
fn the_small_scenes_ask_only_where_surfaces_share_a_place() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "gltf") {
            continue;
        }
        let scene = gltf::read(&path, &gltf::Options::default()).unwrap().build().unwrap();
        let name = path.file_stem().unwrap().to_str().unwrap();
        assert_eq!(scene.shared_places.is_some(), SHARED.contains(&name), "{name}");
        seen += 1;
    }
    assert!(seen > 10);
}
