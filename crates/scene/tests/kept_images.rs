//! Images that are kept between readings of a file.
#![cfg(feature = "gltf")]

use dapple_scene::gltf::{KeptImages, Options, read};
use std::path::Path;

/// A kept image gives the same textures as a decoded one.
#[test]
fn kept_images_change_no_texture() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/normal_maps.gltf");
    let textures = |images: Option<KeptImages>| {
        let scene = read(&file, &Options { images, ..Options::default() }).unwrap().build().unwrap();
        assert!(!scene.textures.is_empty());
        format!("{:?}", scene.textures)
    };
    let images = KeptImages::default();
    let decoded = textures(None);
    assert_eq!(textures(Some(images.clone())), decoded);
    assert_eq!(images.saved().as_nanos(), 0);
    assert_eq!(textures(Some(images.clone())), decoded);
    assert!(images.saved().as_nanos() > 0);
}
