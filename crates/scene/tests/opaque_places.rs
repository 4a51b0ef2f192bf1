//! Scenes without coincident surfaces store no data about them: objects that stand on a floor do not count.
#![cfg(feature = "gltf")]

use dapple_scene::gltf;
use std::path::Path;

/// Scenes with emitters in emitters or in walls, and with clear objects on a floor.
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
