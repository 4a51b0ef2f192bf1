//! No file makes the program use more memory or time than is plausible for its size and the machine: excessive requests
//! are rejected beforehand, with the amount, and merely unusual files are rendered.

mod dapple;

use dapple::{Run, run, triangle};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// A small, quiet render of few samples.
const QUICK: [&str; 7] = ["--size", "4x4", "--spp", "1", "--quiet", "-o", "a.exr"];

/// Expects one error message that contains each of `words`.
fn refused(run: &Run, words: &[&str]) {
    assert_eq!(run.code, 2, "{}", run.err);
    assert_eq!(run.err.trim_end().lines().count(), 1, "{}", run.err);
    for word in words {
        assert!(run.err.contains(word), "'{word}' is not in: {}", run.err);
    }
}

/// An OpenEXR image of 2 × 1 pixels in a frame of `width` × `height`.
fn frame([width, height]: [i32; 2]) -> Vec<u8> {
    let mut exr = b"\x76\x2f\x31\x01\x02\0\0\0".to_vec();
    let channel = |name: char| format!("{name}\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0");
    let window = |x: i32, y: i32| [0, 0, x - 1, y - 1].map(i32::to_le_bytes).concat();
    for (name, kind, value) in [
        ("channels", "chlist", format!("{}{}{}\0", channel('B'), channel('G'), channel('R')).into_bytes()),
        ("compression", "compression", vec![0]),
        ("dataWindow", "box2i", window(2, 1)),
        ("displayWindow", "box2i", window(width, height)),
        ("lineOrder", "lineOrder", vec![0]),
        ("pixelAspectRatio", "float", 1f32.to_le_bytes().to_vec()),
        ("screenWindowCenter", "v2f", vec![0; 8]),
        ("screenWindowWidth", "float", 1f32.to_le_bytes().to_vec()),
    ] {
        exr.extend(format!("{name}\0{kind}\0").bytes());
        exr.extend((value.len() as u32).to_le_bytes());
        exr.extend(value);
    }
    exr.push(0);
    exr.extend((exr.len() as u64 + 8).to_le_bytes());
    exr.extend([0u32, 24].map(u32::to_le_bytes).concat());
    exr.extend([0.5f32; 6].map(f32::to_le_bytes).concat());
    exr
}

/// A black PNG of one bit per pixel, compressed as far as deflate allows.
fn black_png(width: u32, height: u32) -> Vec<u8> {
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |kind: &[u8; 4], content: &[u8]| {
        png.extend((content.len() as u32).to_be_bytes());
        let body = [&kind[..], content].concat();
        png.extend(&body);
        png.extend(crc32(&body).to_be_bytes());
    };
    chunk(b"IHDR", &[&width.to_be_bytes()[..], &height.to_be_bytes(), &[1, 0, 0, 0, 0]].concat());
    chunk(b"IDAT", &zeros_deflated(u64::from(width.div_ceil(8) + 1) * u64::from(height)));
    chunk(b"IEND", &[]);
    png
}

/// `count` zeros as a zlib stream: one literal, then copies of 258 and, at the end, literals (RFC 1951, fixed codes).
fn zeros_deflated(count: u64) -> Vec<u8> {
    let (mut bytes, mut bits, mut held) = (vec![0x78, 0x9c], 0u64, 0);
    let mut put = |value: u64, length: u32| {
        bits |= value << held;
        held += length;
        while held >= 8 {
            bytes.push(bits as u8);
            (bits, held) = (bits >> 8, held - 8);
        }
    };
    put(0b011, 3);
    // Codes are written first bit first: literal 0 is 00110000, length 258 is 11000101, distance 1 is 00000.
    let literal = |put: &mut dyn FnMut(u64, u32)| put(0b0000_1100, 8);
    literal(&mut put);
    let rest = count - 1;
    (0..rest / 258).for_each(|_| put(0b1010_0011, 13));
    (0..rest % 258).for_each(|_| literal(&mut put));
    put(0, 7 + 7);
    bytes.extend((((count % 65_521) << 16) as u32 | 1).to_be_bytes());
    bytes
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 })
    })
}

/// A triangle, and a node that shows it `instances` times with `vertices` vertices, both without data in the file.
fn without_data(instances: u64, vertices: u64) -> String {
    triangle(|root, _| {
        root["accessors"] = json!([
            { "componentType": 5126, "count": vertices, "type": "VEC3" },
            { "componentType": 5126, "count": instances, "type": "VEC3" },
        ]);
        root["meshes"][0]["primitives"] = json!([{ "attributes": { "POSITION": 0 } }]);
        instance(root, 1);
    })
}

fn instance(root: &mut Value, translations: usize) {
    let used = json!(["EXT_mesh_gpu_instancing"]);
    (root["extensionsUsed"], root["extensionsRequired"]) = (used.clone(), used);
    root["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": translations } } });
}

/// The triangle at many positions, with one long name for all instances.
fn one_name(instances: usize, name: &str) -> String {
    triangle(|root, bytes| {
        bytes.resize(44, 0);
        bytes.extend((0..3 * instances).flat_map(|i| (i as f32 * 1e-3).to_le_bytes()));
        let length = 12 * instances;
        root["bufferViews"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "buffer": 0, "byteOffset": 44, "byteLength": length }));
        let accessor = json!({ "bufferView": 2, "componentType": 5126, "count": instances, "type": "VEC3" });
        root["accessors"].as_array_mut().unwrap().push(accessor);
        root["buffers"][0]["byteLength"] = (44 + length).into();
        root["nodes"][0]["name"] = name.into();
        instance(root, 2);
    })
}

/// `triangles` degenerate triangles, all of one corner, at `instances` positions.
fn placed(instances: usize, triangles: usize) -> String {
    let mut root: Value = serde_json::from_str(&one_name(instances, "triangle")).unwrap();
    root["accessors"][1] =
        json!({ "bufferView": 2, "componentType": 5121, "count": 3 * triangles, "type": "SCALAR" });
    root.to_string()
}

/// `primitives` triangles that share one accessor of `vertices` positions.
fn shared(primitives: u64, vertices: u64) -> String {
    triangle(|root, bytes| {
        let place = |i: u64| [(i % 100) as f32, (i / 100) as f32, (i % 7) as f32];
        bytes.resize(44, 0);
        bytes.extend((0..vertices).flat_map(place).flat_map(f32::to_le_bytes));
        let view = json!({ "buffer": 0, "byteOffset": 44, "byteLength": 12 * vertices });
        root["bufferViews"].as_array_mut().unwrap().push(view);
        root["buffers"][0]["byteLength"] = bytes.len().into();
        root["accessors"][0] =
            json!({ "bufferView": 2, "componentType": 5126, "count": vertices, "type": "VEC3" });
        let one = root["meshes"][0]["primitives"][0].clone();
        root["meshes"][0]["primitives"] = (0..primitives).map(|_| one.clone()).collect();
    })
}

/// `nodes` nodes that show a mesh of `primitives` triangles.
fn shown_often(nodes: usize, primitives: usize) -> String {
    triangle(|root, _| {
        let one = root["meshes"][0]["primitives"][0].clone();
        root["meshes"][0]["primitives"] = (0..primitives).map(|_| one.clone()).collect();
        root["nodes"] = (0..nodes).map(|i| json!({ "mesh": 0, "translation": [i, 0, 0] })).collect();
        root["scenes"][0]["nodes"] = (0..nodes).collect();
    })
}

/// A Radiance HDR of one colour, of run-length coded rows.
fn flat_hdr(side: u16) -> Vec<u8> {
    let mut row = vec![2, 2];
    row.extend(side.to_be_bytes());
    for _ in 0..4 {
        (0..side / 127).for_each(|_| row.extend([0xff, 0x80]));
        row.extend([128 + (side % 127) as u8, 0x80]);
    }
    let mut hdr = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {side} +X {side}\n").into_bytes();
    (0..side).for_each(|_| hdr.extend(&row));
    hdr
}

/// `length` lamps, each the child of the one before; those in `moving` slide.
fn lamps(length: usize, moving: std::ops::Range<usize>) -> String {
    triangle(|root, bytes| {
        bytes.resize(44, 0);
        bytes.extend([0.0f32, 1.0, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0].iter().flat_map(|x| x.to_le_bytes()));
        root["buffers"][0]["byteLength"] = 76.into();
        let views = root["bufferViews"].as_array_mut().unwrap();
        views.extend(
            [(44, 8), (52, 24)].map(|(o, n)| json!({ "buffer": 0, "byteOffset": o, "byteLength": n })),
        );
        let accessors = root["accessors"].as_array_mut().unwrap();
        accessors.push(json!({ "bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR" }));
        accessors.push(json!({ "bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3" }));
        let nodes = root["nodes"].as_array_mut().unwrap();
        let first = nodes.len();
        nodes.extend((0..length).map(|i| {
            let mut node = json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } });
            if i + 1 < length {
                node["children"] = json!([first + i + 1]);
            }
            node
        }));
        root["scenes"][0]["nodes"] = json!([0, 1, first]);
        root["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        root["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
        let channel = |i| json!({ "sampler": 0, "target": { "node": first + i, "path": "translation" } });
        let channels: Vec<Value> = moving.map(channel).collect();
        root["animations"] = json!([{ "samplers": [{ "input": 2, "output": 3 }], "channels": channels }]);
    })
}

/// A triangle with the image as its base colour.
fn textured(picture: &[u8]) -> String {
    use base64::Engine;
    triangle(|root, _| {
        let encoded = base64::engine::general_purpose::STANDARD.encode(picture);
        root["images"] = json!([{ "name": "black", "uri": format!("data:image/png;base64,{encoded}") }]);
        root["textures"] = json!([{ "source": 0 }]);
        root["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        root["meshes"][0]["primitives"][0]["material"] = 0.into();
    })
}

#[test]
fn what_a_small_file_blows_up_to_is_refused_with_the_figure() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("frame.exr"), frame([16_384, 16_384])).unwrap();
    fs::write(at("bomb.png"), black_png(16_384, 16_384)).unwrap();
    fs::write(at("lies.hdr"), "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 16384\n").unwrap();
    fs::write(at("texture.gltf"), textured(&black_png(16_384, 16_384))).unwrap();
    fs::write(at("placed.gltf"), placed(100_000, 10_000)).unwrap();
    fs::write(at("often.gltf"), shown_often(1500, 3000)).unwrap();
    fs::write(at("flat.hdr"), flat_hdr(16_000)).unwrap();
    let dapple = |arguments: &[&str]| run(folder.path(), arguments);
    let render = |arguments: &[&str]| dapple(&[&["render"], arguments, &QUICK].concat());
    refused(
        &render(&["--env", "frame.exr"]),
        &["frame.exr", "data for 2 pixels in a display window of 16384×16384"],
    );
    refused(&render(&["--env", "lies.hdr"]), &["lies.hdr", "16384×16384", " GB ", "--memory-limit"]);
    refused(&render(&["--env", "bomb.png"]), &["bomb.png", "5.1 GB", "--memory-limit 6GB"]);
    refused(&render(&["--env", "flat.hdr"]), &["flat.hdr", "16000×16000", "7.7 GB", "--memory-limit 8GB"]);
    refused(
        &dapple(&["diff", "bomb.png", "bomb.png"]),
        &["bomb.png", "268435456 pixels", "36.8 GB", "--memory-limit"],
    );
    refused(&render(&["texture.gltf"]), &["texture.gltf", "image 0 'black'", "2.4 GB", "--memory-limit 3G"]);
    let words = ["placed.gltf", "1000000000 triangles", "node 0 'triangle'", "480.1 GB", "--memory-limit"];
    refused(&render(&["placed.gltf"]), &words);
    refused(&render(&["often.gltf"]), &["often.gltf", "4500000 objects", "7.3 GB", "--memory-limit 8GB"]);
    let film = dapple(&["render", "--size", "1000000x1000000", "--aov", "albedo,normal"]);
    refused(&film, &["--size", "1000000000000 pixels", "668000.0 GB", "--memory-limit", "--crop"]);
    assert!(!at("a.exr").exists());
}

#[test]
fn a_large_frame_that_is_full_is_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("frame.exr"), frame([8, 4])).unwrap();
    dapple::well(folder.path(), &[&["render", "--env", "frame.exr"], &QUICK[..]].concat());
}

#[test]
fn the_users_word_decides_and_a_file_beside_the_scene_has_none() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.gltf"), triangle(|_, _| {})).unwrap();
    let render = |more: &[&str]| run(folder.path(), &[&["render", "scene.gltf"], more, &QUICK].concat());
    let little = render(&["--memory-limit", "1000"]);
    refused(&little, &["scene.gltf", "--memory-limit allows 1.0 kB", "--memory-limit 1G"]);
    assert_eq!(render(&["--memory-limit", "1G"]).code, 0);
    let in_use = render(&["--memory-limit", "1M"]);
    refused(&in_use, &["MB in use", "--memory-limit allows 1.0 MB", "--memory-limit 1GB"]);
    refused(
        &run(folder.path(), &["info", "scene.gltf", "--memory-limit", "1000"]),
        &["scene.gltf", "1.0 kB"],
    );
    refused(&run(folder.path(), &["diff", "a.exr", "a.exr", "--memory-limit", "1000"]), &["a.exr", "1.0 kB"]);
    refused(&render(&["--memory-limit", "lots"]), &["--memory-limit"]);
    fs::write(folder.path().join("scene.toml"), "memory-limit = '1000'\n").unwrap();
    let ignored = render(&[]);
    assert_eq!(ignored.code, 0, "{}", ignored.err);
    assert!(ignored.err.contains("'memory-limit'"), "{}", ignored.err);
    fs::remove_file(folder.path().join("scene.toml")).unwrap();
    fs::write(folder.path().join("mine.toml"), "memory-limit = '1000'\n").unwrap();
    refused(&render(&["--settings", "mine.toml"]), &["1.0 kB"]);
}

/// Runs with 1.5 GB of address space; checks that the process neither ends by a signal nor takes more than `seconds`.
#[cfg(target_os = "linux")]
fn confined(folder: &Path, arguments: &[&str], seconds: u64) -> (i32, String) {
    use std::process::Command;
    let confine = format!("ulimit -v 1500000; exec timeout {seconds} \"$0\" \"$@\"");
    let output = Command::new("sh")
        .args(["-c", &confine, env!("CARGO_BIN_EXE_dapple")])
        .args(arguments)
        .args(["--threads", "2"])
        .current_dir(folder)
        .output()
        .unwrap();
    (output.status.code().unwrap_or(-1), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Each of these files once took gigabytes or minutes, growing quadratically with the file; now they fit into little
/// memory.
#[cfg(target_os = "linux")]
#[test]
fn odd_files_stay_small_and_quick() {
    let folder = tempfile::tempdir().unwrap();
    let many = |n: usize| (0..n).map(|i| format!("VENDOR_{i}")).collect::<Vec<_>>();
    let scenes = [
        ("name", one_name(20_000, &"n".repeat(500_000)), 0),
        ("chain", lamps(4000, 0..1), 0),
        ("deep", lamps(2000, 1000..1001), 0),
        ("moving", lamps(4000, 0..4000), 2),
        (
            "extensions",
            triangle(|root, _| {
                root["extensionsUsed"] = json!(many(60_000));
                root["extensionsRequired"] = json!(many(60_000));
            }),
            0,
        ),
        ("shared", shared(20_000, 200_000), 0),
        ("points", without_data(1_000_000, 1_000_000), 0),
        (
            "nested",
            format!(
                "{{\"asset\":{{\"version\":\"2.0\"}},\"extras\":{}{}}}",
                "[".repeat(50_000),
                "]".repeat(50_000)
            ),
            2,
        ),
    ];
    for (name, scene, code) in scenes {
        let file = format!("{name}.gltf");
        fs::write(folder.path().join(&file), scene).unwrap();
        let render = [&["render", &file, "--shutter", "0:1"], &QUICK[..]].concat();
        let (found, err) = confined(folder.path(), &render, 120);
        assert_eq!(found, code, "{name}: {err}");
        assert!(err.len() < 20_000, "{name}: {} bytes of messages", err.len());
    }
}

/// A request within the machine's memory but beyond the limits of the process is also rejected.
#[cfg(target_os = "linux")]
#[test]
fn the_limits_of_the_process_count() {
    let folder = tempfile::tempdir().unwrap();
    let (code, err) = confined(folder.path(), &["render", "--size", "4096x4096", "-o", "a.exr"], 120);
    assert_eq!(code, 2, "{err}");
    assert!(err.contains("--size") && err.contains("is free"), "{err}");
}
