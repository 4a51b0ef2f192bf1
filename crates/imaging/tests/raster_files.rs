//! Tests reading and writing of PNG, JPEG, WebP and HDR, and the handling of other files in the folder.
#![cfg(feature = "png")]

use dapple_imaging::color::{luminance, srgb_to_linear};
use dapple_imaging::write::{PngDepth, PngOptions};
use dapple_imaging::{Image, ImageError, Layers, Rgba8, Rgba16, Texels, Tone, read, write};
use glam::Vec3;
use image::{ExtendedColorType as Color, ImageEncoder};
use std::io::Cursor;
use std::path::{Path, PathBuf};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn gradient(width: usize, height: usize, top: f32) -> Image {
    let n = width * height;
    let colour = |i: usize| {
        Vec3::new(i as f32 / n as f32, ((i * 7) % n) as f32 / n as f32, ((i * 31) % n) as f32 / n as f32)
            * top
    };
    Image { width, height, pixels: (0..n).map(colour).collect() }
}

fn png(width: u32, height: u32, data: &[u8], color: Color) -> Vec<u8> {
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes).write_image(data, width, height, color).unwrap();
    bytes
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    all.sort();
    all
}

#[test]
fn png_keeps_every_code_value() {
    let folder = folder();
    let path = folder.path().join("a.png");
    let data: Vec<u8> = (0..=255u8).flat_map(|v| [v, 255 - v, v ^ 0x5a]).collect();
    write::rgb8(&path, 16, 16, data.clone()).unwrap();
    let picture = read::picture(&path).unwrap();
    assert_eq!(write::code_values(&picture, Tone::Srgb, 0.0), data);
    let texture = read::rgba8(&std::fs::read(&path).unwrap(), "a").unwrap();
    let rgba: Vec<[u8; 4]> = data.chunks(3).map(|c| [c[0], c[1], c[2], 255]).collect();
    assert_eq!((texture.width, texture.height, texture.texels), (16, 16, rgba));
}

#[test]
fn png_rounds_to_the_nearest_code_value() {
    let folder = folder();
    let path = folder.path().join("a.PNG");
    let picture = gradient(40, 25, 1.0);
    write::png(&path, &picture, Tone::Srgb, 0.0).unwrap();
    for (a, b) in read::picture(&path).unwrap().pixels.iter().zip(&picture.pixels) {
        let code = |v: f32| dapple_imaging::color::linear_to_srgb(v);
        let error = (a.map(code) - b.map(code)).abs().max_element();
        assert!(error <= 0.5 / 255.0 + 1e-6, "{b} came back as {a}");
    }
}

/// The colours of a PNG with coverage are those of the covering surface at any coverage; 16 bits round 256 times as
/// finely.
#[test]
fn coverage_is_unassociated_and_sixteen_bits_are_finer() {
    let folder = folder();
    let path = folder.path().join("cover.png");
    let colour = Vec3::new(0.3, 0.002, 0.9);
    let alpha: Vec<f32> = (0..8).map(|i| i as f32 / 7.0).chain([-0.1, 1.2]).collect();
    let pixels = alpha.iter().map(|a| colour * *a).collect();
    let picture = Image { width: 5, height: 2, pixels };
    for depth in [PngDepth::Eight, PngDepth::Sixteen] {
        let options = PngOptions { exposure: 0.1, depth, alpha: Some(&alpha), ..PngOptions::default() };
        write::png_with(&path, &picture, &options).unwrap();
        let decoded = image::open(&path).unwrap();
        let (most, step): (f64, i32) = match depth {
            PngDepth::Eight => (255.0, 257),
            PngDepth::Sixteen => (65_535.0, 1),
        };
        assert_eq!(u32::from(decoded.color().bytes_per_pixel()), 4 * if step == 1 { 2 } else { 1 });
        for (i, pixel) in decoded.into_rgba16().pixels().enumerate() {
            let a = alpha[i].clamp(0.0, 1.0);
            let code = |v: f32| ((f64::from(v) * most + 0.5).floor() * f64::from(step)) as i32;
            let expected = match a {
                0.0 => [0; 4],
                a => {
                    let shown = Tone::Srgb.apply(colour * (alpha[i] / a) * libm_exp2(0.1));
                    [code(shown.x), code(shown.y), code(shown.z), code(a)]
                }
            };
            for (c, (found, expected)) in pixel.0.into_iter().zip(expected).enumerate() {
                // Multiplying by the coverage and dividing again causes an error in the last bit.
                let off = (i32::from(found) - expected).abs();
                assert!(off <= if c == 3 { 0 } else { step }, "{depth:?} {i} {c}: {found} {expected}");
            }
        }
    }
    let options = PngOptions { alpha: Some(&alpha[1..]), ..PngOptions::default() };
    assert!(matches!(write::png_with(&path, &picture, &options), Err(ImageError::Inconsistent { .. })));
}

fn libm_exp2(x: f32) -> f32 {
    f64::from(x).exp2() as f32
}

#[test]
fn exposure_is_in_stops() {
    let picture = gradient(8, 8, 0.5);
    let doubled = Image { pixels: picture.pixels.iter().map(|p| *p * 4.0).collect(), ..picture.clone() };
    let tones = Tone::ALL.map(|(tone, _)| tone);
    for tone in tones {
        assert_eq!(write::code_values(&picture, tone, 2.0), write::code_values(&doubled, tone, 0.0));
    }
}

#[test]
fn sixteen_bits_keep_their_depth() {
    let folder = folder();
    let path = folder.path().join("deep.png");
    let values: Vec<u16> = vec![0, 1, 257, 32_768, 40_000, 65_535];
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
    std::fs::write(&path, png(2, 1, &data, Color::Rgb16)).unwrap();
    let picture = read::picture(&path).unwrap();
    let expected: Vec<f32> = values.iter().map(|&v| srgb_to_linear(f32::from(v) / 65_535.0)).collect();
    for (a, b) in picture.pixels.iter().flat_map(|p| p.to_array()).zip(&expected) {
        assert!((a - b).abs() <= 1e-6 * b.max(1e-3), "{a} is not {b}");
    }
    let narrow = read::rgba8(&std::fs::read(&path).unwrap(), "deep").unwrap();
    assert_eq!(narrow.texels, [[0, 0, 1, 255], [128, 156, 255, 255]]);
}

/// Textures: values that 8 bits represent take 8 bits; all others keep 16.
#[test]
fn textures_of_sixteen_bits_keep_what_they_say() {
    let bytes = |values: [u16; 6]| png(2, 1, &values.map(u16::to_ne_bytes).concat(), Color::Rgb16);
    let deep = read::texels(&bytes([0, 1, 257, 32_768, 40_000, 65_535]), "deep").unwrap();
    let kept =
        Rgba16 { width: 2, height: 1, texels: vec![[0, 1, 257, 65_535], [32_768, 40_000, 65_535, 65_535]] };
    assert_eq!(deep, Texels::Sixteen(kept));
    let flat = read::texels(&bytes([0, 257, 514, 771, 65_535, 65_278]), "flat").unwrap();
    let kept = Rgba8 { width: 2, height: 1, texels: vec![[0, 1, 2, 255], [3, 255, 254, 255]] };
    assert_eq!((flat.bytes(), flat), (8, Texels::Eight(kept)));
    let grey =
        read::texels(&png(1, 1, &[1000u16, 2000].map(u16::to_ne_bytes).concat(), Color::La16), "g").unwrap();
    assert_eq!(grey, Texels::Sixteen(Rgba16 { width: 1, height: 1, texels: vec![[1000, 1000, 1000, 2000]] }));
}

#[test]
fn grey_and_alpha_are_expanded() {
    let cases: [(Color, &[u8], [u8; 4]); 4] = [
        (Color::L8, &[90], [90, 90, 90, 255]),
        (Color::La8, &[90, 30], [90, 90, 90, 30]),
        (Color::Rgb8, &[1, 2, 3], [1, 2, 3, 255]),
        (Color::Rgba8, &[1, 2, 3, 0], [1, 2, 3, 0]),
    ];
    let folder = folder();
    let path = folder.path().join("a.png");
    for (color, data, expected) in cases {
        let bytes = png(1, 1, data, color);
        assert_eq!(read::rgba8(&bytes, "a").unwrap().texels, [expected], "{color:?}");
        std::fs::write(&path, bytes).unwrap();
        let linear =
            Vec3::from([expected[0], expected[1], expected[2]].map(|c| srgb_to_linear(f32::from(c) / 255.0)));
        assert!((read::picture(&path).unwrap().pixels[0] - linear).abs().max_element() < 1e-6, "{color:?}");
        let grey = matches!(color, Color::L8 | Color::La8);
        assert_eq!(read::channels(&path).unwrap(), if grey { "Y" } else { "RGB" }, "{color:?}");
    }
}

#[test]
fn jpeg_and_webp_by_content() {
    let folder = folder();
    // With the wrong extension, the content determines the format.
    let path = folder.path().join("photo.png");
    let data: Vec<u8> = (0..64 * 64).flat_map(|i| [(i % 64 * 4) as u8, 100, (i / 64 * 4) as u8]).collect();
    let mut jpeg = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 95)
        .write_image(&data, 64, 64, Color::Rgb8)
        .unwrap();
    std::fs::write(&path, &jpeg).unwrap();
    let picture = read::picture(&path).unwrap();
    assert_eq!((picture.width, picture.height), (64, 64));
    let back = write::code_values(&picture, Tone::Srgb, 0.0);
    let error: f64 = back.iter().zip(&data).map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
    assert!(error / (data.len() as f64) < 2.0, "mean error {}", error / data.len() as f64);
    let mut webp = Vec::new();
    image::codecs::webp::WebPEncoder::new_lossless(&mut webp)
        .write_image(&data, 64, 64, Color::Rgb8)
        .unwrap();
    std::fs::write(&path, &webp).unwrap();
    assert_eq!(write::code_values(&read::picture(&path).unwrap(), Tone::Srgb, 0.0), data);
    assert_eq!(read::rgba8(&webp, "w").unwrap().texels[1], [4, 100, 0, 255]);
}

#[test]
fn hdr_within_half_a_mantissa_step() {
    let folder = folder();
    // Widths that are written uncompressed and with run lengths, the latter including long runs.
    for (width, height) in [(5, 7), (40, 25), (300, 3)] {
        let path = folder.path().join("a.hdr");
        let mut picture = gradient(width, height, 1000.0);
        picture.pixels[..width].fill(Vec3::new(3.0, 1.0, 0.25));
        picture.pixels[1] = Vec3::ZERO;
        write::hdr(&path, &picture).unwrap();
        let back = read::picture(&path).unwrap();
        assert_eq!((back.width, back.height), (width, height));
        let mut bias = 0.0;
        for (a, b) in back.pixels.iter().zip(&picture.pixels) {
            assert!((*a - *b).abs().max_element() <= b.max_element() / 256.0, "{b} came back as {a}");
            bias += f64::from(luminance(*a) - luminance(*b));
        }
        assert_eq!((back.pixels[0], back.pixels[1]), (Vec3::new(3.0, 1.0, 0.25), Vec3::ZERO));
        let brightness: f64 = picture.pixels.iter().map(|p| f64::from(luminance(*p))).sum();
        assert!((bias / brightness).abs() < 2e-3, "bias {}", bias / brightness);
    }
}

#[test]
fn old_radiance_signature_is_read() {
    let folder = folder();
    let path = folder.path().join("a.hdr");
    let mut bytes = b"#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
    bytes.extend([128, 64, 32, 129, 255, 0, 0, 136]);
    std::fs::write(&path, bytes).unwrap();
    assert_eq!(read::picture(&path).unwrap().pixels, [Vec3::new(1.0, 0.5, 0.25), Vec3::new(255.0, 0.0, 0.0)]);
}

#[test]
fn bombs_are_refused_before_they_go_off() {
    let folder = folder();
    let mut bytes = png(1, 1, &[0], Color::L8);
    bytes[16..20].copy_from_slice(&60_000u32.to_be_bytes());
    bytes[20..24].copy_from_slice(&60_000u32.to_be_bytes());
    let crc = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    let error = read::rgba8(&bytes, "bomb").unwrap_err();
    assert!(matches!(error, ImageError::TooLarge { width: 60_000, .. }), "{error}");
    let path = folder.path().join("bomb.hdr");
    std::fs::write(&path, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n").unwrap();
    assert!(matches!(read::picture(&path).unwrap_err(), ImageError::TooLarge { .. }));
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 })
    })
}

#[test]
fn errors_name_the_file_and_the_remedy() {
    let folder = folder();
    let says = |name: &str, content: Option<&[u8]>, words: &[&str]| {
        let path = folder.path().join(name);
        if let Some(content) = content {
            std::fs::write(&path, content).unwrap();
        }
        let message = read::picture(&path).unwrap_err().to_string();
        for word in words.iter().chain(&[name]) {
            assert!(message.contains(word), "{message}");
        }
    };
    says("none.exr", None, &["no such file", "check the path"]);
    says("words.txt", Some(b"hello"), &["unknown image format", "convert"]);
    says("empty.png", Some(b""), &["damaged or truncated"]);
    says("words.exr", Some(b"hello"), &[]);
    says("words.hdr", Some(b"hello"), &["damaged or truncated"]);
    std::fs::create_dir(folder.path().join("folder.png")).unwrap();
    says("folder.png", None, &["not a regular file"]);
    let message = read::rgba8(b"GIF89a..", "scene.glb, image 3").unwrap_err().to_string();
    assert!(message.contains("scene.glb, image 3"), "{message}");
    assert!(read::rgba8(b"#?RADIANCE\n", "x").unwrap_err().to_string().contains("as a texture"));
    std::fs::write(folder.path().join("a.png"), png(1, 1, &[0], Color::L8)).unwrap();
    assert!(read::layers(&folder.path().join("a.png")).unwrap_err().to_string().contains("EXR"));
}

#[test]
fn a_failed_write_changes_nothing() {
    let folder = folder();
    let path = folder.path().join("a.png");
    std::fs::write(&path, "precious").unwrap();
    let wrong = Image { width: 3, height: 3, pixels: vec![Vec3::ONE; 8] };
    for error in [
        write::png(&path, &wrong, Tone::Srgb, 0.0).unwrap_err(),
        write::hdr(&path, &wrong).unwrap_err(),
        write::rgb8(&path, 1, 1, vec![1, 2]).unwrap_err(),
        write::png(&path, &Image::filled(0, 0, Vec3::ONE), Tone::Srgb, 0.0).unwrap_err(),
    ] {
        assert!(
            matches!(error, ImageError::Inconsistent { .. }) && error.to_string().contains("a.png"),
            "{error}"
        );
    }
    assert_eq!(std::fs::read(&path).unwrap(), b"precious");
    let good = gradient(4, 4, 1.0);
    let missing = folder.path().join("no/such/a.png");
    assert!(matches!(write::png(&missing, &good, Tone::Srgb, 0.0).unwrap_err(), ImageError::NoFolder { .. }));
    assert_eq!(files(folder.path()), [path]);
}

#[test]
fn check_tells_beforehand_and_leaves_nothing() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("dir.png")).unwrap();
    for good in ["a.png", "b.HDR", "c.tar.png"] {
        write::check(&at(good)).unwrap();
    }
    assert!(matches!(write::check(&at("a.tiff")), Err(ImageError::UnknownExtension(_))));
    assert!(matches!(write::check(&at("a")), Err(ImageError::UnknownExtension(_))));
    assert!(matches!(write::check(&at("none/a.png")), Err(ImageError::NoFolder { .. })));
    assert!(matches!(write::check(&at("dir.png")), Err(ImageError::NotAFile { .. })));
    assert_eq!(files(folder.path()), [at("dir.png")]);
    assert_eq!(write::check(&at("a.exr")).is_ok(), cfg!(feature = "exr"));
}

#[cfg(unix)]
#[test]
fn files_are_ordinary_ones() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
    std::fs::write(at("plain"), "").unwrap(); // the mode that the umask gives to new files
    write::hdr(&at("a.hdr"), &gradient(4, 4, 1.0)).unwrap();
    assert_eq!(mode(&at("a.hdr")), mode(&at("plain")));
    // A link is preserved, and the file it points to is replaced.
    symlink(at("a.hdr"), at("link.hdr")).unwrap();
    write::hdr(&at("link.hdr"), &gradient(5, 4, 1.0)).unwrap();
    assert!(std::fs::symlink_metadata(at("link.hdr")).unwrap().is_symlink());
    assert_eq!(read::picture(&at("a.hdr")).unwrap().width, 5);
    // Devices are not replaced.
    symlink("/dev/null", at("null.hdr")).unwrap();
    assert!(matches!(write::check(&at("null.hdr")), Err(ImageError::NotAFile { .. })));
    assert!(matches!(write::hdr(&at("null.hdr"), &gradient(5, 4, 1.0)), Err(ImageError::NotAFile { .. })));
}

/// Only missing data are reported: a file without an end marker but with all other data contains its whole image.
#[test]
fn a_jpeg_is_cut_short_where_texels_are_missing() {
    use dapple_imaging::{MemoryLimit, read::Gap};
    let texels = |bytes: &[u8]| read::texels_within(bytes, "a", MemoryLimit::NONE).unwrap();
    let gap = |bytes: &[u8]| read::gap(bytes, &texels(bytes), "a", MemoryLimit::NONE);
    for (width, height) in [(17, 19), (64, 48), (8, 8)] {
        let data = write::code_values(&gradient(width as usize, height as usize, 2.0), Tone::Srgb, 0.0);
        let mut jpeg = Vec::new();
        image::codecs::jpeg::JpegEncoder::new(&mut jpeg)
            .write_image(&data, width, height, Color::Rgb8)
            .unwrap();
        let whole = texels(&jpeg);
        assert_eq!(gap(&jpeg), None);
        let end = jpeg.len() - 2;
        assert_eq!(jpeg[end..], [0xff, 0xd9]);
        for kept in [end, end + 1] {
            assert_eq!(gap(&jpeg[..kept]), None, "{width}x{height}");
            assert!(texels(&jpeg[..kept]) == whole);
        }
        for missing in [8, 12, 40] {
            let cut = &jpeg[..end - missing];
            let ended = [cut, &[0xff, 0xd9]].concat();
            assert_eq!([gap(cut), gap(&ended)], [Some(Gap::Grey); 2], "{width}x{height} without {missing}");
            // Data after the image, such as another image, say nothing about it.
            assert_eq!(gap(&[&jpeg[..], &jpeg[2..], &[7; 9]].concat()), None);
            assert_eq!(gap(&[&ended[..], &jpeg[..]].concat()), Some(Gap::Grey));
        }
    }
    assert_eq!(gap(&png(3, 2, &[7; 18], Color::Rgb8)), None);
}

/// No modification of a valid file causes a panic or an endless loop on reading; wrong images are possible.
#[test]
fn damaged_files_never_panic() {
    let folder = folder();
    let path = folder.path().join("a");
    let picture = gradient(17, 19, 2.0);
    let data = write::code_values(&picture, Tone::Srgb, 0.0);
    let mut jpeg = Vec::new();
    image::codecs::jpeg::JpegEncoder::new(&mut jpeg).write_image(&data, 17, 19, Color::Rgb8).unwrap();
    let mut webp = Cursor::new(Vec::new());
    image::codecs::webp::WebPEncoder::new_lossless(&mut webp)
        .write_image(&data, 17, 19, Color::Rgb8)
        .unwrap();
    let mut samples = vec![png(17, 19, &data, Color::Rgb8), jpeg, webp.into_inner()];
    let hdr = folder.path().join("a.hdr");
    write::hdr(&hdr, &picture).unwrap();
    samples.push(std::fs::read(&hdr).unwrap());
    if cfg!(feature = "exr") {
        let exr = folder.path().join("a.exr");
        write::exr(&exr, &Layers::from(&picture), write::Depth::Half).unwrap();
        samples.push(std::fs::read(&exr).unwrap());
    }
    let attempt = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let _ = read::layers(&path);
        let _ = read::rgba8(bytes, "a");
        read::picture(&path)
    };
    for (kind, good) in samples.iter().enumerate() {
        attempt(good).unwrap();
        for cut in (0..good.len()).filter(|c| *c < 60 || c % 17 == 0) {
            let result = attempt(&good[..cut]);
            // Only a trailer may be missing: PNG's IEND and checksums; JPEG decoders fill missing data with grey.
            assert!(
                result.is_err() || cut + 32 > good.len() || kind == 1,
                "kind {kind} cut at {cut} was read"
            );
        }
        for at in (0..good.len()).filter(|at| *at < 500 || at % 29 == 0) {
            let mut bytes = good.clone();
            bytes[at] ^= [0x01, 0x80, 0xff][at % 3];
            let _ = attempt(&bytes);
        }
    }
}
