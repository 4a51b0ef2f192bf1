//! Integration tests of `dapple diff`: its measures, its output, and its exit codes.

mod dapple;

use dapple::{files, run, well};
use dapple_imaging::{Image, Layer, Layers, Tone, read, write};
use glam::Vec3;
use std::path::Path;

fn save(folder: &Path, name: &str, picture: &Image) {
    write::exr(&folder.join(name), &Layers::from(picture), write::Depth::Float).unwrap();
}

/// Writes a 6×4 image with a ramp, and one that is brighter by ¼ in red and off by 2 in the blue of one pixel.
fn pair(folder: &Path) {
    let reference = (0..24).map(|i| Vec3::new(i as f32 / 16.0, 1.0, 0.5)).collect();
    let reference = Image { width: 6, height: 4, pixels: reference };
    save(folder, "b.exr", &reference);
    let mut image = reference;
    image.pixels.iter_mut().for_each(|p| p.x += 0.25);
    image.pixels[15].z += 2.0;
    save(folder, "a.exr", &image);
}

#[test]
fn numbers_and_map() {
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    let json = well(folder.path(), &["diff", "a.exr", "b.exr", "-o", "heat.png", "--json"]).json();
    let mse = (24.0 * 0.0625 + 4.0) / 72.0;
    let close = |key: &str, x: f64| {
        let found = json[key].as_f64().unwrap_or(f64::NAN);
        assert!((found - x).abs() <= 1e-12, "{key}: {found} for {x}");
    };
    close("mse", mse);
    close("rmse", f64::sqrt(mse));
    close("bias", (24.0 * 0.25 + 2.0) / 72.0);
    close("psnr", -10.0 * f64::log10(mse));
    close("max_error", 2.0);
    assert_eq!((&json["max_error_pixel"], &json["nan_pixels"]), (&serde_json::json!([3, 2]), &0.into()));
    assert_eq!(json["channels"]["r"]["mse"], 0.0625);
    assert_eq!(json["channels"]["g"]["mse"], 0.0);
    for key in ["relmse", "relmse_trimmed", "mape", "smape", "flip", "flip_ldr", "flip_hdr", "epsilon"] {
        assert!(json[key].as_f64().is_some_and(|x| x > 0.0), "{key}: {json}");
    }
    let map = read::picture(&folder.path().join("heat.png")).unwrap();
    assert_eq!((map.width, map.height), (6, 4));
    assert!(map.pixels[15].y > 4.0 * map.pixels[17].y, "{} {}", map.pixels[15], map.pixels[17]);
    let text = well(folder.path(), &["diff", "a.exr", "b.exr"]).out;
    assert!(text.contains("relmse") && text.contains("3,2"), "{text}");
}

#[test]
fn every_map_is_written() {
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    for map in ["relative", "signed", "flip"] {
        let name = format!("{map}.png");
        well(folder.path(), &["diff", "a.exr", "b.exr", "--map", map, "-o", &name]);
    }
    well(folder.path(), &["diff", "a.exr", "b.exr", "-o", "difference.exr"]);
    let difference = read::picture(&folder.path().join("difference.exr")).unwrap();
    assert_eq!(difference.pixels[15], Vec3::new(0.25, 0.0, 2.0));
    assert_eq!(files(folder.path()).len(), 6);
}

#[test]
fn limits_decide_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    let code = |limits: &[&str]| {
        let limits: Vec<&str> = limits.iter().flat_map(|l| ["--fail-above", l]).collect();
        run(folder.path(), &[&["diff", "a.exr", "b.exr", "--json"], &limits[..]].concat()).code
    };
    assert_eq!(code(&["mse=0.1"]), 0);
    assert_eq!(code(&["mse=0.01"]), 1);
    assert_eq!(code(&["mse=0.1", "max_error=1"]), 1);
    assert_eq!(code(&["nan_pixels=0"]), 0);
    assert_eq!(code(&["mice=0.1"]), 2);
    assert_eq!(code(&["mse"]), 2);
}

#[test]
fn pixels_that_are_not_finite_are_told() {
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    let mut spoiled = read::picture(&folder.path().join("a.exr")).unwrap();
    spoiled.pixels[15].y = f32::NAN;
    save(folder.path(), "nan.exr", &spoiled);
    let json = well(folder.path(), &["diff", "nan.exr", "b.exr", "--json", "-o", "heat.png"]).json();
    assert_eq!((&json["nan_pixels"], &json["pixels"]), (&1.into(), &23.into()));
    assert_eq!(json["nan_pixel"], serde_json::json!([3, 2]));
    assert!((json["mse"].as_f64().unwrap() - 0.0625 / 3.0).abs() < 1e-12);
    let code = run(folder.path(), &["diff", "nan.exr", "b.exr", "--fail-above", "nan_pixels=0"]).code;
    assert_eq!(code, 1);
}

#[test]
fn two_halves() {
    let folder = tempfile::tempdir().unwrap();
    for (name, value) in [("a.exr", 1.5), ("r1.exr", 0.5), ("r2.exr", 1.0)] {
        save(folder.path(), name, &Image::filled(4, 4, Vec3::splat(value)));
    }
    let arguments = ["diff", "a.exr", "r1.exr", "--reference-half", "r2.exr", "--json"];
    let json = well(folder.path(), &arguments).json();
    assert_eq!((&json["mse"], &json["bias"]), (&0.5.into(), &0.75.into()));
    assert_eq!(json["reference_mse"], 0.0625);
}

#[test]
fn every_format_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let picture = Image::filled(5, 3, Vec3::new(0.25, 0.5, 1.0));
    save(folder.path(), "a.exr", &picture);
    write::hdr(&folder.path().join("a.hdr"), &picture).unwrap();
    write::png(&folder.path().join("a.png"), &picture, Tone::Srgb, 0.0).unwrap();
    for (a, b, flips) in [("a.hdr", "a.exr", true), ("a.png", "a.exr", true), ("a.png", "a.png", false)] {
        let json = well(folder.path(), &["diff", a, b, "--json"]).json();
        assert!(json["max_error"].as_f64().unwrap() < 4e-3, "{json}");
        assert_eq!(json["flip_hdr"].is_number(), flips);
    }
    // Too small for the window of SSIM; large enough.
    for (name, size, ssim) in [("a.exr", 5, None), ("large.exr", 12, Some(1.0))] {
        save(folder.path(), "large.exr", &Image::filled(size, size, Vec3::ONE));
        assert_eq!(well(folder.path(), &["diff", name, name, "--json"]).json()["ssim"].as_f64(), ssim);
    }
    let equal = well(folder.path(), &["diff", "a.exr", "a.exr", "--json"]).json();
    assert_eq!((&equal["mse"], &equal["flip"]), (&0.0.into(), &0.0.into()));
    assert!(equal["psnr"].is_null());
}

/// A crop contains a part of its image: only the pixels in both files are compared, and positions are those of the full
/// image.
#[test]
fn crops_are_compared_where_they_overlap() {
    let folder = tempfile::tempdir().unwrap();
    let full = (0..24).map(|i| Vec3::splat(1.0 + i as f32 / 16.0)).collect();
    let full = Image { width: 6, height: 4, pixels: full };
    save(folder.path(), "full.exr", &full);
    let crop = |name: &str, x: usize, y: usize, w: usize, h: usize, change: &dyn Fn(&mut Image)| {
        let pixels = (y..y + h).flat_map(|y| (x..x + w).map(move |x| (x, y))).map(|(x, y)| full.at(x, y));
        let mut part = Image { width: w, height: h, pixels: pixels.collect() };
        change(&mut part);
        let layers = Layers { offset: (x as i32, y as i32), full_size: (6, 4), ..Layers::from(&part) };
        write::exr(&folder.path().join(name), &layers, write::Depth::Float).unwrap();
    };
    crop("same.exr", 1, 1, 3, 2, &|_| {});
    crop("off.exr", 2, 1, 4, 3, &|p| p.pixels[5].x += 2.0);
    crop("far.exr", 0, 3, 2, 1, &|_| {});
    let of = |a: &str, b: &str| well(folder.path(), &["diff", a, b, "--json", "-o", "d.exr"]).json();
    for (a, b) in [("same.exr", "full.exr"), ("full.exr", "same.exr")] {
        let json = of(a, b);
        assert_eq!((&json["mse"], &json["pixels"], &json["relmse"]), (&0.0.into(), &6.into(), &0.0.into()));
        assert_eq!(json["window"], serde_json::json!([1, 1, 4, 3]));
    }
    let json = of("off.exr", "full.exr");
    assert_eq!(json["max_error_pixel"], serde_json::json!([3, 2]));
    assert!((json["mse"].as_f64().unwrap() - 4.0 / 36.0).abs() < 1e-12, "{json}");
    // The error map covers the compared pixels.
    let map = read::layers(&folder.path().join("d.exr")).unwrap();
    assert_eq!((map.offset, map.full_size, map.width, map.height), ((2, 1), (6, 4), 4, 3));
    let both = of("off.exr", "same.exr");
    assert_eq!((&both["pixels"], &both["max_error"]), (&4.into(), &2.0.into()));
    let halves = ["diff", "full.exr", "same.exr", "--reference-half", "off.exr"];
    let text = well(folder.path(), &halves).out;
    assert!(text.contains("4 pixels") && text.contains("2,1 to 4,3 of 6x4"), "{text}");
    for arguments in [&["same.exr", "far.exr"][..], &["full.exr", "same.exr", "--reference-half", "far.exr"]]
    {
        let found = run(folder.path(), &[&["diff"], arguments].concat());
        assert_eq!(found.code, 2, "{arguments:?}: {}", found.out);
        assert!(found.err.contains("far.exr") && found.err.contains("no pixel in common"), "{}", found.err);
    }
}

/// A rendered crop equals that part of the whole image.
#[test]
fn a_rendered_crop_has_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let base = ["render", "builtin:cornell", "--size", "24x16", "--spp", "4"];
    well(folder.path(), &[&base[..], &["-o", "full.exr"]].concat());
    well(folder.path(), &[&base[..], &["--crop", "5,3,14,11", "-o", "crop.exr"]].concat());
    let json = well(folder.path(), &["diff", "crop.exr", "full.exr", "--json"]).json();
    assert_eq!((&json["max_error"], &json["full_size"]), (&0.0.into(), &serde_json::json!([24, 16])));
    assert!(json["pixels"].as_u64().unwrap() < 24 * 16);
}

#[test]
fn what_cannot_be_compared() {
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    save(folder.path(), "small.exr", &Image::filled(3, 4, Vec3::ONE));
    let grey = Layer { name: String::new(), channels: vec![("Y".into(), vec![0.5; 24])] };
    let grey = Layers { width: 6, height: 4, layers: vec![grey], ..Layers::default() };
    write::exr(&folder.path().join("grey.exr"), &grey, write::Depth::Float).unwrap();
    std::fs::write(folder.path().join("text.exr"), "no picture").unwrap();
    for (arguments, named) in [
        (&["a.exr", "small.exr"][..], &["small.exr", "6x4", "3x4"][..]),
        (&["a.exr", "b.exr", "--reference-half", "small.exr"], &["small.exr"]),
        (&["a.exr", "grey.exr"], &["grey.exr", "channels"]),
        (&["a.exr", "missing.exr"], &["missing.exr"]),
        (&["text.exr", "a.exr"], &["text.exr"]),
        (&["a.exr", "b.exr", "-o", "missing/heat.png"], &["missing"]),
        (&["a.exr", "b.exr", "-o", "heat.hdr"], &["heat.hdr"]),
        (&["a.exr", "b.exr", "--epsilon", "0"], &["--epsilon"]),
        (&["a.exr", "b.exr", "--map", "love"], &["--map"]),
        (&["a.exr"], &["REFERENCE"]),
    ] {
        let found = run(folder.path(), &[&["diff"], arguments].concat());
        assert_eq!(found.code, 2, "{arguments:?}: {}", found.err);
        assert_eq!(found.err.lines().count(), 1, "{}", found.err);
        assert!(named.iter().all(|n| found.err.contains(n)), "{arguments:?}: {}", found.err);
    }
    assert_eq!(files(folder.path()).len(), 5);
}
