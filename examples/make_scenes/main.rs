//! Writes the scenes of `scenes/`: `cargo run --release --example make_scenes [FOLDER]`.
//!
//! The output is the same on every machine: positions are computed in f64 with `libm`, and nothing is random. The
//! purpose of each scene, and the source of its numbers, are described in `scenes/README.md`.

mod classics;
mod document;
mod effects;
mod media;
mod normals;
mod places;
mod plain;
mod shape;
mod sky;

use std::error::Error;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("scenes"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    let checker = png_bytes(&plain::checker())?;
    for (name, document) in [
        ("cornell", classics::cornell()),
        ("cornell_spheres", classics::cornell_spheres()),
        ("veach_mis", classics::veach_mis()),
        ("furnace", plain::furnace()),
        ("environment", plain::environment()),
        ("motion_blur", plain::motion_blur()),
        ("antialias", plain::antialias(&checker)),
        ("soft_shadow", effects::soft_shadow()),
        ("blurred_reflection", effects::blurred_reflection(&checker)),
        ("depth_of_field", effects::depth_of_field()),
        ("nested_media", media::nested_media()),
        ("panes", media::panes()),
        ("all_effects", effects::all_effects(&checker)),
        ("normal_maps", normals::normal_maps(&png_bytes(&normals::studs())?)),
        ("coincident", places::coincident()),
        ("coplanar", places::coplanar()),
    ] {
        std::fs::write(folder.join(name).with_extension("gltf"), document.to_text())?;
        println!("{name}.gltf");
    }
    for (name, sky) in [("sky.hdr", sky::picture()), ("town.hdr", sky::town())] {
        dapple_imaging::write::hdr(&folder.join(name), &sky)?;
        println!("{name}");
    }
    for (name, text) in plain::SIDECARS.into_iter().chain(effects::SIDECARS).chain(media::SIDECARS) {
        std::fs::write(folder.join(name), text)?;
        println!("{name}");
    }
    Ok(())
}

/// Encodes an image as a PNG file in sRGB.
fn png_bytes(picture: &dapple_imaging::Image) -> Result<Vec<u8>, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let path: &Path = &folder.path().join("texture.png");
    dapple_imaging::write::png(path, picture, dapple_imaging::Tone::Srgb, 0.0)?;
    Ok(std::fs::read(path)?)
}
