//! What is written is read back, and no damaged file ends the program.
#![cfg(all(feature = "exr", feature = "png"))]

use dapple_imaging::{Layer, Layers, MetaValue, Picture, Tone, read, write};
use glam::Vec3;

fn sample(width: usize, height: usize) -> Picture {
    let pixels = (0..width * height)
        .map(|i| Vec3::new(i as f32 * 0.01, 1.0 / (i + 1) as f32, (i * i % 97) as f32))
        .collect();
    Picture { width, height, pixels }
}

#[test]
fn exr_keeps_floats_layers_window_and_facts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let picture = sample(13, 7);
    let mut layers = Layers::from(&picture);
    layers.layers.push(Layer {
        name: "depth".into(),
        channels: vec![("Z".into(), (0..91).map(|i| i as f32).collect())],
    });
    layers.offset = (5, 3);
    layers.full_size = (40, 20);
    layers.metadata = vec![("spp".into(), MetaValue::Int(64)), ("seed".into(), MetaValue::Text("7".into()))];
    write::exr(&path, &layers, write::Depth::Float).unwrap();
    let back = read::layers(&path).unwrap();
    assert_eq!(back.beauty().unwrap(), picture);
    assert_eq!((back.offset, back.full_size), ((5, 3), (40, 20)));
    assert!(back.layers.contains(&layers.layers[1]));
    assert_eq!(back.metadata, [("dapple".into(), MetaValue::Text("spp = 64\nseed = 7\n".into()))]);
    let first = std::fs::read(&path).unwrap();
    write::exr(&path, &layers, write::Depth::Float).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), first, "same bytes twice");
    write::exr(&path, &layers, write::Depth::Half).unwrap();
    let half = read::picture(&path).unwrap();
    assert!(
        half.pixels
            .iter()
            .zip(&picture.pixels)
            .all(|(a, b)| (*a - *b).abs().max_element() <= b.max_element() * 1e-3)
    );
}

#[test]
fn png_and_hdr_round_trip() {
    let folder = tempfile::tempdir().unwrap();
    let picture = Picture::filled(5, 4, Vec3::new(0.18, 0.5, 0.9));
    let path = folder.path().join("a.png");
    write::png(&path, &picture, Tone::Srgb, 0.0).unwrap();
    assert!((read::picture(&path).unwrap().pixels[7] - picture.pixels[7]).abs().max_element() < 4e-3);
    let path = folder.path().join("a.hdr");
    write::hdr(&path, &sample(9, 9)).unwrap();
    let back = read::picture(&path).unwrap();
    for (a, b) in back.pixels.iter().zip(&sample(9, 9).pixels) {
        assert!((*a - *b).abs().max_element() <= b.max_element() / 120.0);
    }
}

#[test]
fn damaged_files_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let picture = sample(16, 16);
    let write_all = |name: &str| {
        let path = folder.path().join(name);
        match name {
            "a.exr" => write::exr(&path, &(&picture).into(), write::Depth::Float),
            "a.png" => write::png(&path, &picture, Tone::Aces, 0.0),
            _ => write::hdr(&path, &picture),
        }
        .unwrap();
        path
    };
    for name in ["a.exr", "a.png", "a.hdr"] {
        let path = write_all(name);
        let good = std::fs::read(&path).unwrap();
        for cut in (0..good.len().min(600)).step_by(7) {
            std::fs::write(&path, &good[..cut]).unwrap();
            let _ = read::picture(&path);
        }
        std::fs::write(&path, &good[..good.len() / 3]).unwrap();
        let damaged = read::picture(&path);
        assert!(damaged.is_err() || name == "a.hdr", "{name}");
        for at in (0..good.len()).step_by(1 + good.len() / 300) {
            let mut bytes = good.clone();
            bytes[at] ^= 0x55;
            std::fs::write(&path, &bytes).unwrap();
            let _ = read::picture(&path);
        }
    }
    let missing = read::picture(&folder.path().join("none.exr")).unwrap_err().to_string();
    assert!(missing.contains("none.exr") && missing.contains("check the path"), "{missing}");
}

#[test]
fn failures_leave_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    std::fs::write(&path, b"precious").unwrap();
    let mut layers = Layers::from(&sample(3, 3));
    layers.layers[0].channels[0].1.pop();
    assert!(write::exr(&path, &layers, write::Depth::Float).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), b"precious");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(write::check(&folder.path().join("no/such/a.exr")).is_err());
    assert!(write::check(&folder.path().join("a.xyz")).is_err());
    assert!(write::check(&path).is_ok());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
