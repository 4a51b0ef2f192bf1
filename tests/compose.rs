//! Integration tests of images for compositing: alpha, Cryptomatte, and PNG metadata.
#![cfg(all(feature = "exr", feature = "png"))]

mod dapple;

use dapple::{triangle, well};
use dapple_imaging::{Layers, MetaValue, read};
use std::path::Path;

const SMALL: [&str; 8] = ["--env-color", "1,1,1", "--size", "40x28", "--spp", "5", "--exposure", "0"];

fn render(folder: &Path, more: &[&str]) {
    std::fs::write(folder.join("a.gltf"), triangle(|_, _| ())).unwrap();
    well(folder, &[&["render", "a.gltf"], &SMALL[..], more].concat());
}

fn exr(folder: &Path, name: &str) -> Layers {
    read::layers(&folder.join(name)).unwrap()
}

fn channel<'a>(layers: &'a Layers, layer: &str, channel: &str) -> &'a [f32] {
    let layer = layers.layer(layer).unwrap_or_else(|| panic!("no layer {layer}"));
    &layer.channels.iter().find(|(name, _)| name == channel).unwrap_or_else(|| panic!("no {channel}")).1
}

/// Returns the kinds and contents of the chunks of a PNG.
fn chunks(path: &Path) -> Vec<(String, Vec<u8>)> {
    let bytes = std::fs::read(path).unwrap();
    let (mut at, mut all) = (8, Vec::new());
    while at < bytes.len() {
        let length = u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let kind = String::from_utf8(bytes[at + 4..at + 8].to_vec()).unwrap();
        all.push((kind, bytes[at + 8..at + 8 + length].to_vec()));
        at += 12 + length;
    }
    all
}

fn texts(path: &Path) -> Vec<String> {
    let is_text = |(kind, _): &(String, Vec<u8>)| kind == "tEXt" || kind == "iTXt";
    let all = chunks(path).into_iter().filter(is_text);
    all.map(|(_, body)| String::from_utf8(body).unwrap()).collect()
}

#[test]
fn alpha_is_there_where_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    render(at, &["-o", "plain.exr", "-o", "plain.png"]);
    assert_eq!(exr(at, "plain.exr").layer("").unwrap().channels.len(), 3);
    assert_eq!(chunks(&at.join("plain.png"))[0].1[8..10], [8, 2], "8 bits, RGB");
    for method in ["path", "distribution"] {
        let more = ["--transparent", "--method", method, "--pixel", "5", "--png-depth", "16"];
        render(at, &[&more[..], &["-o", "cut.exr", "-o", "cut.png", "-o", "cut.hdr"]].concat());
        let layers = exr(at, "cut.exr");
        let (alpha, green) = (channel(&layers, "", "A"), channel(&layers, "", "G"));
        let whole = alpha.iter().filter(|a| **a == 1.0).count();
        let none = alpha.iter().filter(|a| **a == 0.0).count();
        assert!(whole > 20 && none > 20 && whole + none < alpha.len(), "{method}: {alpha:?}");
        // Fifths, associated.
        for (a, g) in alpha.iter().zip(green) {
            let part = a * 5.0;
            assert!((part - part.round()).abs() < 1e-6 && (*a > 0.0 || *g == 0.0), "{a} {g}");
        }
        assert_eq!(chunks(&at.join("cut.png"))[0].1[8..10], [16, 6], "16 bits, RGBA");
    }
}

#[test]
fn a_png_says_how_it_was_made() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    render(at, &["--transparent", "--png-depth", "16", "--tone", "agx", "-o", "a.png"]);
    let path = at.join("a.png");
    let kinds: Vec<String> = chunks(&path).into_iter().map(|(kind, _)| kind).collect();
    assert_eq!(kinds[..4], ["IHDR", "sRGB", "tEXt", "tEXt"]);
    let texts = texts(&path);
    assert!(texts[0].starts_with("Software\0dapple "), "{texts:?}");
    let settings = texts[1].strip_prefix("settings\0").unwrap();
    // The settings reproduce the file.
    std::fs::write(at.join("again.toml"), settings).unwrap();
    let again = ["render", "a.gltf", "--settings", "again.toml", "-o", "b.png"];
    well(at, &again);
    assert!(std::fs::read(&path).unwrap() == std::fs::read(at.join("b.png")).unwrap(), "{settings}");
}

/// Ids keep all their bits in a file of half floats, and every id has a name.
#[test]
fn cryptomatte_survives_half_floats() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (name, more) in [("float.exr", &[][..]), ("half.exr", &["--half"][..])] {
        render(at, &[&["--aov", "beauty,cryptomatte,object,material", "-o", name], more].concat());
    }
    let [float, half] = ["float.exr", "half.exr"].map(|name| exr(at, name));
    for layer in ["CryptoObject00", "CryptoObject02", "CryptoMaterial00"] {
        for c in ["R", "G", "B", "A"] {
            assert_eq!(channel(&float, layer, c), channel(&half, layer, c), "{layer}.{c}");
        }
    }
    assert!(channel(&float, "", "G") != channel(&half, "", "G"));
    let text = |key: &str| match float.metadata.iter().find(|(name, _)| name == key) {
        Some((_, MetaValue::Text(text))) => text.clone(),
        _ => panic!("no {key}"),
    };
    // The keys are the first seven digits of the names' hashes.
    assert_eq!(
        (text("cryptomatte/3ae39a5/name"), text("objectNames")),
        ("CryptoObject".into(), r#"{"triangle":[1]}"#.into())
    );
    let ids = channel(&float, "CryptoObject00", "R");
    let id = ids.iter().map(|id| id.to_bits()).find(|id| *id != 0).unwrap();
    assert_eq!(text("cryptomatte/3ae39a5/manifest"), format!("{{\"triangle\":\"{id:08x}\"}}"));
    assert!(ids.iter().all(|other| other.to_bits() == id || *other == 0.0));
}
