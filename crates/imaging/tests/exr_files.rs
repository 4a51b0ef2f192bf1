//! Tests that EXR files are read as they were written, bit for bit, and that equal content gives equal bytes.
#![cfg(feature = "exr")]

use dapple_imaging::write::Depth;
use dapple_imaging::{Image, Layer, Layers, MetaValue, read, write};
use glam::Vec3;
use std::path::PathBuf;

const WIDTH: usize = 37;
const HEIGHT: usize = 41; // three ZIP blocks, the last one short

/// A hash of an index.
fn noise(i: usize) -> u32 {
    let mut x = (i as u32).wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x.wrapping_mul(0x846c_a68b) ^ (x >> 16)
}

/// All kinds of floats: finite ones of any exponent, infinities, NaN, −0.
fn awkward(i: usize) -> f32 {
    match i % 13 {
        0 => f32::INFINITY,
        1 => f32::NEG_INFINITY,
        2 => f32::NAN,
        3 => -0.0,
        4 => f32::from_bits(noise(i) % 100), // subnormal
        _ => f32::from_bits(noise(i) & 0xff7f_ffff),
    }
}

/// Values within the normal range of half.
fn tame(i: usize) -> f32 {
    (noise(i) % 1_000_003) as f32 / 997.0 + 0.001
}

fn layers(value: fn(usize) -> f32) -> Layers {
    let count = WIDTH * HEIGHT;
    let layer = |name: &str, channels: &[&str], salt: usize| Layer {
        name: name.into(),
        channels: channels
            .iter()
            .enumerate()
            .map(|(c, n)| (n.to_string(), (0..count).map(|i| value(i + (salt + c) * 10_007)).collect()))
            .collect(),
    };
    Layers {
        width: WIDTH,
        height: HEIGHT,
        offset: (5, 9),
        full_size: (64, 50),
        layers: vec![
            layer("", &["R", "G", "B"], 0),
            layer("albedo", &["R", "G", "B"], 3),
            layer("depth", &["Z"], 6),
            layer("normal", &["X", "Y", "Z"], 7),
            layer("object_id", &["Y"], 10),
            layer("variance", &["R", "G", "B"], 11),
        ],
        metadata: metadata(),
    }
}

/// Sorted by name, as returned by reading.
fn metadata() -> Vec<(String, MetaValue)> {
    let matrix = |k: f32| MetaValue::Matrix(std::array::from_fn(|i| k * i as f32));
    vec![
        ("dapple/eta".into(), MetaValue::Float(1.5)),
        ("dapple/pattern".into(), MetaValue::Text("4×4 stratified, «Grüße»".into())),
        ("dapple/spp".into(), MetaValue::Int(64)),
        ("dapple/view".into(), matrix(3.0)),
        ("software".into(), MetaValue::Text("dapple 0.1.0".into())),
        ("worldToCamera".into(), matrix(1.0)),
        ("worldToNDC".into(), matrix(-2.0)),
    ]
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.exr");
    (folder, path)
}

fn bits(layers: &Layers) -> Vec<(String, String, Vec<u32>)> {
    let values = |v: &[f32]| v.iter().map(|v| v.to_bits()).collect();
    layers
        .layers
        .iter()
        .flat_map(|l| l.channels.iter().map(|(c, v)| (l.name.clone(), c.clone(), values(v))))
        .collect()
}

#[test]
fn floats_layers_windows_and_metadata_survive_bit_for_bit() {
    let (_folder, path) = folder();
    let before = layers(awkward);
    write::exr(&path, &before, Depth::Float).unwrap();
    let after = read::layers(&path).unwrap();
    assert_eq!(bits(&after), bits(&before));
    assert_eq!((after.width, after.height), (WIDTH, HEIGHT));
    assert_eq!((after.offset, after.full_size), (before.offset, before.full_size));
    assert_eq!(after.metadata, before.metadata);
}

#[test]
fn half_rounds_colour_and_keeps_data() {
    let (_folder, path) = folder();
    let mut before = layers(tame);
    before.layers[0].channels[0].1[0] = 1e9;
    write::exr(&path, &before, Depth::Half).unwrap();
    let after = read::layers(&path).unwrap();
    for (a, b) in after.layers.iter().zip(&before.layers) {
        let half = ["", "albedo", "normal"].contains(&a.name.as_str());
        for ((channel, a_values), (_, b_values)) in a.channels.iter().zip(&b.channels) {
            let limit = if half { 1.0 / 2048.0 } else { 0.0 };
            for (x, y) in a_values.iter().zip(b_values) {
                let y = if half { y.min(65504.0) } else { *y };
                assert!((x - y).abs() <= limit * y, "{}.{channel}: {y} came back as {x}", a.name);
            }
            assert_eq!(half, a_values != b_values, "{}.{channel}", a.name);
        }
    }
    assert_eq!(after.layers[0].channels[0].1[0], 65504.0);
}

#[test]
fn equal_content_gives_equal_bytes_whatever_the_threads() {
    let (_folder, path) = folder();
    let mut all = Vec::new();
    for threads in [1, 2, 4, 1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| write::exr(&path, &layers(awkward), Depth::Float)).unwrap();
        all.push(std::fs::read(&path).unwrap());
    }
    assert!(all.iter().all(|bytes| *bytes == all[0]));
    // The order of the attributes does not change the content.
    let mut shuffled = layers(awkward);
    shuffled.metadata.reverse();
    shuffled.layers.reverse();
    write::exr(&path, &shuffled, Depth::Float).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), all[0]);
}

#[test]
fn a_picture_is_the_display_window() {
    let (_folder, path) = folder();
    let before = layers(tame);
    write::exr(&path, &before, Depth::Float).unwrap();
    let picture = read::picture(&path).unwrap();
    assert_eq!((picture.width, picture.height), (64, 50));
    let beauty = before.picture("").unwrap();
    for y in 0..50 {
        for x in 0..64 {
            let inside = (5..5 + WIDTH).contains(&x) && (9..9 + HEIGHT).contains(&y);
            let expected = if inside { beauty.pixels[(y - 9) * WIDTH + x - 5] } else { Vec3::ZERO };
            assert_eq!(picture.pixels[y * 64 + x], expected, "({x}, {y})");
        }
    }
}

#[test]
fn a_data_window_larger_than_the_display_is_cut() {
    let (_folder, path) = folder();
    let mut before = layers(tame);
    (before.offset, before.full_size) = ((-3, -4), (20, 21));
    write::exr(&path, &before, Depth::Float).unwrap();
    let (picture, beauty) = (read::picture(&path).unwrap(), before.picture("").unwrap());
    assert_eq!((picture.width, picture.height), (20, 21));
    assert_eq!(picture.pixels[0], beauty.pixels[4 * WIDTH + 3]);
    assert_eq!(picture.pixels[20 * 21 - 1], beauty.pixels[24 * WIDTH + 22]);
    assert_eq!(read::layers(&path).unwrap().offset, (-3, -4));
}

#[test]
fn a_crop_knows_what_it_holds() {
    let (_folder, path) = folder();
    let before = layers(tame);
    write::exr(&path, &before, Depth::Float).unwrap();
    let (found, beauty) = (read::windowed(&path).unwrap(), before.picture("").unwrap());
    assert_eq!((found.window.x, found.window.y, found.full_size), (5, 9, (64, 50)));
    assert_eq!(found.picture, beauty);
    // Larger than the display window, and therefore clipped to it.
    let larger = Layers { offset: (-3, -4), full_size: (20, 21), ..layers(tame) };
    write::exr(&path, &larger, Depth::Float).unwrap();
    let found = read::windowed(&path).unwrap();
    assert_eq!((found.window, found.full_size), (dapple_imaging::Window::full((20, 21)), (20, 21)));
    assert_eq!(found.picture, read::picture(&path).unwrap());
    let outside = Layers { offset: (64, 0), full_size: (64, 50), ..layers(tame) };
    write::exr(&path, &outside, Depth::Float).unwrap();
    let said = read::windowed(&path).unwrap_err().to_string();
    assert!(said.contains("outside of its display window"), "{said}");
}

#[test]
fn luminance_and_prefixed_colour_are_found() {
    let (_folder, path) = folder();
    let channel = |name: &str, v: f32| (name.to_string(), vec![v; 6]);
    let one = |layers| Layers { width: 3, height: 2, layers, ..Layers::default() };
    let layer = |name: &str, channels| Layer { name: name.into(), channels };
    let grey = one(vec![layer("", vec![channel("Y", 0.25)])]);
    write::exr(&path, &grey, Depth::Float).unwrap();
    assert_eq!(read::picture(&path).unwrap(), Image::filled(3, 2, Vec3::splat(0.25)));
    assert_eq!(read::channels(&path).unwrap(), "Y");
    let prefixed = one(vec![
        layer("a.depth", vec![channel("Z", 9.0)]),
        layer("view.Combined", vec![channel("R", 1.0), channel("G", 2.0), channel("B", 3.0)]),
    ]);
    write::exr(&path, &prefixed, Depth::Half).unwrap();
    assert_eq!(read::picture(&path).unwrap(), Image::filled(3, 2, Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!(read::channels(&path).unwrap(), "RGB");
    let none = one(vec![layer("", vec![channel("Z", 9.0)])]);
    write::exr(&path, &none, Depth::Float).unwrap();
    let message = read::picture(&path).unwrap_err().to_string();
    assert!(message.contains("picture.exr") && message.contains("has Z"), "{message}");
}

#[test]
fn contradictions_are_errors_and_leave_nothing() {
    let (folder, path) = folder();
    let good = layers(tame);
    let broken: Vec<fn(&mut Layers)> = vec![
        |l| l.width = 0,
        |l| l.height += 1,
        |l| l.layers.clear(),
        |l| l.layers[1].name.clear(), // R, G, B twice
        |l| l.layers[2].channels[0].0.clear(),
        |l| l.layers[2].name = "d\0epth".into(),
        |l| l.layers[2].name = "x".repeat(300),
        |l| l.metadata.push(("worldToNDC".into(), MetaValue::Matrix([0.0; 16]))),
        |l| l.metadata.push((String::new(), MetaValue::Int(1))),
        |l| l.metadata.push(("dataWindow".into(), MetaValue::Int(1))),
        |l| l.full_size = (0, 7),
        |l| l.full_size = (usize::MAX, 7),
        |l| l.offset = (i32::MAX, 0),
    ];
    for (i, damage) in broken.into_iter().enumerate() {
        let mut layers = good.clone();
        damage(&mut layers);
        let error = write::exr(&path, &layers, Depth::Float).expect_err(&format!("case {i} was written"));
        assert!(error.to_string().contains("picture.exr"), "{error}");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0, "case {i} left a file");
    }
}

/// Files as written by other programs: every lossless compression, tiles, all three sample types, several parts of
/// different size.
#[test]
fn foreign_files_are_read() {
    use exr::prelude::*;
    let (_folder, path) = folder();
    let size = Vec2(70, 45);
    let value = |i: usize| (i % 1000) as f32;
    let channel = |name: &str, kind: SampleType| {
        let values = (0..size.area()).map(value);
        AnyChannel::new(
            name,
            match kind {
                SampleType::F16 => FlatSamples::F16(values.map(f16::from_f32).collect()),
                SampleType::F32 => FlatSamples::F32(values.collect()),
                SampleType::U32 => FlatSamples::U32(values.map(|v| v as u32).collect()),
            },
        )
    };
    let mixed = || {
        let all = [("R", SampleType::F16), ("G", SampleType::F32), ("B", SampleType::U32)];
        AnyChannels::sort(all.into_iter().map(|(n, k)| channel(n, k)).collect())
    };
    let expected: Vec<Vec3> = (0..size.area()).map(|i| Vec3::splat(value(i))).collect();
    for compression in
        [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ]
    {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(32, 16))] {
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let layer = exr::prelude::Layer::new(size, LayerAttributes::default(), encoding, mixed());
            Image::from_layer(layer).write().to_file(&path).unwrap();
            let picture = dapple_imaging::read::picture(&path).unwrap();
            assert_eq!((picture.width, picture.height), (70, 45));
            assert!(picture.pixels == expected, "{compression:?} {blocks:?}");
        }
    }
    let part = |name: &str, corner: Vec2<i32>, size: Vec2<usize>, v: f32| {
        let attributes = LayerAttributes::named(name).with_position(corner);
        let samples = FlatSamples::F32(vec![v; size.area()]);
        let channels = AnyChannels::sort(smallvec([AnyChannel::new("Y", samples)]));
        exr::prelude::Layer::new(size, attributes, Encoding::FAST_LOSSLESS, channels)
    };
    let parts = [part("near", Vec2(0, 0), Vec2(2, 2), 1.0), part("far", Vec2(1, 1), Vec2(3, 2), 2.0)];
    let window = ImageAttributes::with_size(Vec2(4, 3));
    Image::from_layers(window, parts.to_vec()).write().to_file(&path).unwrap();
    let layers = dapple_imaging::read::layers(&path).unwrap();
    assert_eq!((layers.width, layers.height, layers.offset, layers.full_size), (4, 3, (0, 0), (4, 3)));
    let of = |name: &str| layers.layer(name).unwrap().channels[0].1.clone();
    assert_eq!(of("near"), [1., 1., 0., 0., 1., 1., 0., 0., 0., 0., 0., 0.]);
    assert_eq!(of("far"), [0., 0., 0., 0., 0., 2., 2., 2., 0., 2., 2., 2.]);
    assert_eq!(layers.beauty().unwrap().pixels[0], Vec3::ONE);
}

fn smallvec<T, const N: usize>(items: [T; N]) -> exr::prelude::SmallVec<[T; 4]> {
    items.into_iter().collect()
}
