//! Tests that a build without support for a format returns an error that names the feature on reading, writing and
//! checking.
#![cfg(not(all(feature = "exr", feature = "png")))]

use dapple_imaging::{Image, ImageError, read, write};
use glam::Vec3;

fn assert_left_out<T: std::fmt::Debug>(result: Result<T, ImageError>, feature: &str) {
    let error = result.unwrap_err();
    assert!(matches!(error, ImageError::NotBuiltIn { feature: f, .. } if f == feature), "{error}");
    assert!(error.to_string().contains(&format!("`{feature}`")), "{error}");
}

#[cfg(not(feature = "exr"))]
#[test]
fn exr_says_which_feature_it_wants() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let picture = Image::filled(2, 2, Vec3::ONE);
    assert_left_out(write::check(&path), "exr");
    assert_left_out(write::exr(&path, &dapple_imaging::Layers::from(&picture), write::Depth::Float), "exr");
    std::fs::write(&path, [0x76, 0x2f, 0x31, 0x01]).unwrap();
    assert_left_out(read::picture(&path), "exr");
    assert_left_out(read::layers(&path), "exr");
}

#[cfg(not(feature = "png"))]
#[test]
fn png_says_which_feature_it_wants() {
    let path = std::path::Path::new("a.png");
    let picture = Image::filled(2, 2, Vec3::ONE);
    assert_left_out(write::check(path), "png");
    assert_left_out(write::png(path, &picture, dapple_imaging::Tone::Srgb, 0.0), "png");
    assert_left_out(write::rgb8(path, 1, 1, vec![0; 3]), "png");
    assert_left_out(read::rgba8(&[0x89, b'P', b'N', b'G'], "a"), "png");
    // Writing HDR needs no feature, but reading it does.
    let folder = tempfile::tempdir().unwrap();
    let hdr = folder.path().join("a.hdr");
    write::check(&hdr).unwrap();
    write::hdr(&hdr, &picture).unwrap();
    assert_left_out(read::picture(&hdr), "png");
}
