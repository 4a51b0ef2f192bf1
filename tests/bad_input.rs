//! Bad input of any kind gives one clear line, exit code 2 and no panic, and leaves no file behind.

mod dapple;

use dapple::{files, run, triangle};
use serde_json::json;
use std::fs;
use std::path::Path;

/// Runs in `folder`; expects one error message that contains each of `named`, and no new file in the folder.
fn complains(folder: &Path, arguments: &[&str], named: &[&str]) {
    let before = files(folder);
    let run = run(folder, arguments);
    assert_eq!(run.code, 2, "{arguments:?}: {}", run.err);
    assert_eq!(run.out, "", "{arguments:?}");
    assert_eq!(run.err.trim_end().lines().count(), 1, "{arguments:?}: {}", run.err);
    assert!(run.err.starts_with("error: "), "{arguments:?}: {}", run.err);
    assert!(!run.err.contains("panicked"), "{arguments:?}: {}", run.err);
    for part in named {
        assert!(run.err.contains(part), "{arguments:?}: '{part}' is not in: {}", run.err);
    }
    assert_eq!(files(folder), before, "{arguments:?} left a file behind");
}

/// Creates a folder that contains `scene.gltf`.
fn folder_with(scene: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.gltf"), scene).unwrap();
    folder
}

#[test]
#[allow(clippy::too_many_lines, reason = "a table")]
fn option_values() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, named) in [
        (&["--size", "0x0"][..], "--size"),
        (&["--size", "4x0"], "--size"),
        (&["--size", "4"], "--size"),
        (&["--size", "99999999x1"], "--size"),
        (&["--size", "1000000x1000000"], "--crop"),
        (&["--spp", "0"], "--spp"),
        (&["--spp", "-1"], "-1"),
        (&["--spp", "many"], "--spp"),
        (&["--shutter", "1:0"], "closes at 0 s, before it opens at 1 s"),
        (&["--shutter", "0"], "--shutter"),
        (&["--shutter", "0:nan"], "--shutter"),
        (&["--shutter=-inf:0"], "--shutter"),
        (&["--time-limit", "0s"], "--time-limit"),
        (&["--time-limit", "soon"], "--time-limit"),
        (&["--crop", "0,0,0,4"], "--crop"),
        (&["--crop", "-1,0,4,4"], "--crop"),
        (&["--crop", "0,0,4"], "--crop"),
        (&["--size", "8x8", "--crop", "0,0,9,8"], "8x8"),
        (&["--threads", "0"], "--threads"),
        (&["--seed", "-1"], "-1"),
        (&["--max-bounces", "-1"], "-1"),
        (&["--pattern", "hexagons"], "--pattern"),
        (&["--method", "guesswork"], "--method"),
        (&["--filter", "box:-1"], "--filter"),
        (&["--filter", "box:nan"], "--filter"),
        (&["--tone", "loud"], "--tone"),
        (&["--exposure", "nan"], "--exposure"),
        (&["--aov", "albedo,smell"], "smell"),
        (&["--env-color", "1,1"], "--env-color"),
        (&["--env-color", "1,1,inf"], "--env-color"),
        (&["--env-intensity", "-1"], "--env-intensity"),
        (&["--env", "a.hdr", "--env-color", "1,1,1"], "--env-color"),
        (&["--env", "missing.hdr"], "missing.hdr"),
        (&["--camera", "nobody"], "nobody"),
        (&["--camera", "7"], "7"),
        (&["--settings", "missing.toml"], "missing.toml"),
        (&["--pixel", "0x4"], "--pixel"),
        (&["--light", "abc"], "--light"),
        (&["--glossy", "4x4:hexagons"], "--glossy"),
        (&["--lens", "-1"], "-1"),
        (&["--time", "99999999"], "--time"),
        (&["--combine", "x"], "--combine"),
        (&["--secondary", "0"], "--secondary"),
        (&["--ambient", "1,1,-1"], "--ambient"),
        (&["--aperture-radius", "-1"], "--aperture-radius"),
        (&["--aperture-radius", "nan"], "--aperture-radius"),
        (&["--aperture-shape", "blades:2"], "--aperture-shape"),
        (&["--focus-distance", "0"], "--focus-distance"),
        (&["--focus-distance", "-inf"], "--focus-distance"),
        (&["--no-such-option"], "--no-such-option"),
        (&["builtin:cornell"], "builtin:cornell"),
    ] {
        let all = [&["render", "builtin:cornell"], arguments].concat();
        complains(folder.path(), &all, &[named]);
    }
    let paired = ["render", "builtin:cornell", "--method", "distribution", "--combine", "paired"];
    complains(folder.path(), &[&paired[..], &["--light", "9"]].concat(), &["--light", "9", "16"]);
    complains(folder.path(), &[&paired[..], &["--pixel", "4", "--glossy", "3"]].concat(), &["--glossy"]);
    complains(folder.path(), &["rays", "builtin:cornell", "--lens", "1x"], &["--lens"]);
    complains(folder.path(), &["rays", "missing.glb"], &["missing.glb"]);
    complains(folder.path(), &["render", "builtin:nothing"], &["builtin:nothing", "cornell"]);
    complains(folder.path(), &["sing"], &["sing"]);
    complains(folder.path(), &["replay", "builtin:cornell", "--pixel", "0,0"], &["--sample"]);
    let replay = ["replay", "builtin:cornell", "--sample", "0", "--size", "4x4", "--pixel"];
    complains(folder.path(), &[&replay[..], &["4,0"]].concat(), &["--pixel 4,0", "4x4"]);
    let replay = ["replay", "builtin:cornell", "--pixel", "0,0", "--spp", "4", "--sample", "4"];
    complains(folder.path(), &replay, &["--sample 4"]);
}

#[test]
fn sheets() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(dapple::scene("sky.hdr"), folder.path().join("sky.hdr")).unwrap();
    for (arguments, named) in [
        (&["--vary", "smell", "--counts", "1"][..], "smell"),
        (&["--vary", "light"], "--counts"),
        (&["--counts", "1"], "--vary"),
        (&["--vary", "light", "--counts", "0"], "--counts"),
        (&["--vary", "light", "--counts", ""], "--counts"),
        (&["--vary", "light", "--counts", "1,,2"], "--counts"),
        (&["--vary", "light", "--counts", "1,99999999"], "--counts"),
        (&["--vary", "light", "--counts", "1", "--estimators", "grid,hexagons"], "hexagons"),
        (&["--vary", "light", "--counts", "1", "--estimators", ""], "--estimators"),
        (&["--vary", "light", "--counts", "1", "--reference", "missing.exr"], "missing.exr"),
        (&["--vary", "light", "--counts", "1", "--reference", "sky.hdr", "--size", "8x8"], "sky.hdr"),
        (&["--vary", "light", "--counts", "1", "--size", "4096x4096", "-o", "a.exr"], "a.exr"),
        (&["--vary", "light", "--counts", "1", "-o", "a.png", "-o", "b.png"], "-o"),
        (&["--vary", "light", "--counts", "1", "-o", "missing/a.png"], "missing/a.png"),
        (&["--vary", "light", "--counts", "1,2,3,4", "--size", "8192x8192"], "--size"),
        (&["--vary", "light", "--counts", "1,200000", "--size", "4x4"], "--yes"),
        (&["--vary", "light", "--counts", "9", "--combine", "paired", "--size", "4x4"], "--light"),
        (&["--vary", "lens", "--counts", "1"], "--aperture-radius"),
    ] {
        let all = [&["sheet", "builtin:cornell", "--quiet"], arguments].concat();
        complains(folder.path(), &all, &[named]);
    }
}

#[test]
fn outputs_that_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("taken.png")).unwrap();
    for name in ["missing/a.png", "a.bmp", "a", "taken.png"] {
        complains(folder.path(), &["render", "--size", "4x4", "-o", name], &[name]);
        complains(folder.path(), &["render", "--size", "4x4", "-o", "fine.exr", "-o", name], &[name]);
    }
    complains(folder.path(), &["render", "--size", "4x4", "-o", ""], &["-o"]);
}

/// An OpenEXR image of 4 × 2 pixels, uncompressed: 0.5 everywhere except in the green channel of pixel (3, 1).
fn exr_with(bad: f32) -> Vec<u8> {
    let mut exr = b"\x76\x2f\x31\x01\x02\0\0\0".to_vec();
    let channel = |name: char| format!("{name}\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0");
    let channels = format!("{}{}{}\0", channel('B'), channel('G'), channel('R'));
    let window = [0i32, 0, 3, 1].map(i32::to_le_bytes).concat();
    for (name, kind, value) in [
        ("channels", "chlist", channels.as_bytes()),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", &window),
        ("displayWindow", "box2i", &window),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", &1f32.to_le_bytes()),
        ("screenWindowCenter", "v2f", &[0; 8]),
        ("screenWindowWidth", "float", &1f32.to_le_bytes()),
    ] {
        exr.extend(format!("{name}\0{kind}\0").bytes());
        exr.extend((value.len() as u32).to_le_bytes());
        exr.extend(value);
    }
    exr.push(0);
    let (first, row) = (exr.len() as u64 + 16, 8 + 3 * 4 * 4);
    exr.extend([first, first + row].map(u64::to_le_bytes).concat());
    for y in 0..2u32 {
        exr.extend([y, 48].map(u32::to_le_bytes).concat());
        let value = |k: u32| if (k, y) == (4 + 3, 1) { bad } else { 0.5f32 };
        exr.extend((0..12).flat_map(|k| value(k).to_le_bytes()));
    }
    exr
}

#[test]
fn an_environment_texel_that_is_no_radiance_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let render = ["render", "--env", "sky.exr", "--size", "4x4", "--spp", "1", "-o", "a.exr", "--quiet"];
    fs::write(folder.path().join("sky.exr"), exr_with(0.5)).unwrap();
    assert_eq!(dapple::run(folder.path(), &render).code, 0, "the image is well formed");
    fs::remove_file(folder.path().join("a.exr")).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
        fs::write(folder.path().join("sky.exr"), exr_with(bad)).unwrap();
        complains(folder.path(), &render, &["sky.exr", "(3, 1)"]);
    }
}

#[test]
fn scene_files() {
    let folder = tempfile::tempdir().unwrap();
    complains(folder.path(), &["render", "missing.glb"], &["missing.glb"]);
    complains(folder.path(), &["info", "missing.glb"], &["missing.glb"]);
    complains(folder.path(), &["render", "."], &["."]);
    for (name, bytes) in [
        ("empty.glb", &b""[..]),
        ("header.glb", b"glTF\x02\0\0\0\xff\xff\xff\x7f"),
        ("lies.glb", b"glTF\x02\0\0\0\x14\0\0\0\xff\xff\xff\xffJSON"),
        ("noise.gltf", b"{ \"asset\": "),
        ("list.gltf", b"[]"),
        ("bytes.gltf", b"\xff\xfe\x00"),
    ] {
        fs::write(folder.path().join(name), bytes).unwrap();
        complains(folder.path(), &["render", name], &[name]);
        complains(folder.path(), &["info", name], &[name]);
    }
}

#[test]
fn a_truncated_glb() {
    let mut root: serde_json::Value = serde_json::from_str(&triangle(|_, _| {})).unwrap();
    root["buffers"][0].as_object_mut().unwrap().remove("uri");
    let mut json = root.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    // The last two bytes are padding: without them the file is still truncated.
    let binary = [0u8; 44];
    let length = (12 + 8 + json.len() + 8 + binary.len()) as u32;
    let mut glb = Vec::new();
    glb.extend(b"glTF\x02\0\0\0");
    glb.extend(length.to_le_bytes());
    glb.extend((json.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(&json);
    glb.extend((binary.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(binary);
    let folder = tempfile::tempdir().unwrap();
    for cut in [4, 11, 12, 19, 20, 40, json.len(), json.len() + 20, json.len() + 24, glb.len() - 1] {
        fs::write(folder.path().join("cut.glb"), &glb[..cut]).unwrap();
        complains(folder.path(), &["render", "cut.glb", "--size", "4x4"], &["cut.glb"]);
    }
}

/// An invalid scene, and what the error message must name.
type Spoiled = (&'static str, fn(&mut serde_json::Value, &mut Vec<u8>));

#[test]
fn spoiled_scenes() {
    let cases: [Spoiled; 10] = [
        ("corners 7, 1, 2", |_, bytes| bytes[36] = 7),
        ("vertex 0", |_, bytes| bytes[0..4].copy_from_slice(&f32::NAN.to_le_bytes())),
        ("vertex 0", |_, bytes| bytes[4..8].copy_from_slice(&f32::INFINITY.to_le_bytes())),
        ("buffer", |root, _| root["bufferViews"][0]["byteLength"] = 4000.into()),
        ("accessor", |root, _| root["accessors"][0]["count"] = 4_000_000_000u64.into()),
        ("accessor", |root, _| root["meshes"][0]["primitives"][0]["indices"] = 9.into()),
        ("mesh", |root, _| root["nodes"][0]["mesh"] = 5.into()),
        ("node", |root, _| root["nodes"][0]["children"] = serde_json::json!([0])),
        ("missing.bin", |root, _| root["buffers"][0]["uri"] = "missing.bin".into()),
        ("KHR_unheard_of", |root, _| {
            root["nodes"][0]["extensions"] = serde_json::json!({ "KHR_unheard_of": {} });
            root["extensionsUsed"] = serde_json::json!(["KHR_unheard_of"]);
            root["extensionsRequired"] = serde_json::json!(["KHR_unheard_of"]);
        }),
    ];
    for (named, spoil) in cases {
        let folder = folder_with(&triangle(spoil));
        complains(folder.path(), &["render", "scene.gltf", "--size", "4x4"], &["scene.gltf", named]);
    }
}

#[test]
fn the_unspoiled_scene_renders() {
    let folder = folder_with(&triangle(|_, _| {}));
    dapple::well(folder.path(), &["render", "scene.gltf", "--size", "4x2", "--spp", "1"]);
    assert_eq!(files(folder.path()), ["scene.exr", "scene.gltf", "scene.png"]);
}

#[test]
fn files_outside_the_folder() {
    let outside = tempfile::tempdir().unwrap();
    fs::write(outside.path().join("secret.bin"), [0u8; 42]).unwrap();
    let secret = outside.path().join("secret.bin");
    for uri in [secret.to_str().unwrap(), "../secret.bin", "sub/../../secret.bin", "file:///etc/hostname"] {
        let folder = folder_with(&triangle(|root, _| root["buffers"][0]["uri"] = uri.into()));
        complains(folder.path(), &["render", "scene.gltf"], &["scene.gltf"]);
    }
}

#[test]
fn settings_files() {
    let folder = folder_with(&triangle(|_, _| {}));
    let sidecar = folder.path().join("scene.toml");
    for (text, named) in [
        ("spp = 0", "'spp'"),
        ("spp = 3\nsize = '0x0'", "'size'"),
        ("spp = ", "line 1"),
        ("env = '../sky.hdr'", "'env'"),
    ] {
        fs::write(&sidecar, text).unwrap();
        complains(folder.path(), &["render", "scene.gltf"], &["scene.toml", named]);
    }
    fs::remove_file(&sidecar).unwrap();
    fs::write(folder.path().join("mine.toml"), "sppp = 3").unwrap();
    let arguments = ["render", "scene.gltf", "--settings", "mine.toml"];
    complains(folder.path(), &arguments, &["mine.toml", "'sppp'"]);
}

/// A settings file beside a scene cannot write files, whatever it contains: such keys are ignored, with a warning that
/// names them.
#[test]
fn a_file_beside_the_scene_writes_nothing() {
    let home = tempfile::tempdir().unwrap();
    let package = home.path().join("downloads");
    fs::create_dir(&package).unwrap();
    fs::write(package.join("scene.gltf"), triangle(|_, _| {})).unwrap();
    let keys = home.path().join("keys");
    fs::write(&keys, "precious").unwrap();
    let text =
        "size = '4x4'\nspp = 1\nlog = 'keys'\noutput = ['stolen.exr']\nyes = true\nallow-path = true\n";
    fs::write(package.join("scene.toml"), text).unwrap();
    for more in [&[][..], &["--allow-path"]] {
        let run = dapple::well(home.path(), &[&["render", "downloads/scene.gltf"], more].concat());
        for key in ["scene.toml", "'log'", "'output'", "'yes'", "'allow-path'"] {
            assert!(run.err.contains(key), "{key} is not named: {}", run.err);
        }
        assert_eq!(fs::read_to_string(&keys).unwrap(), "precious");
        assert_eq!(dapple::files(home.path()), ["downloads", "keys", "scene.exr", "scene.png"]);
        assert_eq!(dapple::files(&package), ["scene.gltf", "scene.toml"]);
    }
    let run = dapple::well(home.path(), &["info", "downloads/scene.gltf"]);
    assert!(run.out.contains("scene.toml"), "{}", run.out);
}

/// A settings file beside a scene cannot request an endless render without the user's consent.
#[test]
fn a_file_beside_the_scene_asks_for_no_endless_render() {
    let folder = folder_with(&triangle(|_, _| {}));
    let render = |text: &str, more: &[&str]| {
        fs::write(folder.path().join("scene.toml"), text).unwrap();
        run(folder.path(), &[&["render", "scene.gltf"], more].concat())
    };
    for (text, key, own) in [
        ("spp = 1000000000", "spp", "--spp=1"),
        ("time-limit = '1000h'", "time-limit", "--time-limit=10ms"),
        ("spp = 1\nmax-bounces = 4000000000\nno-roulette = true", "max-bounces", "--max-bounces=2"),
        ("spp = 1000000\nsize = '2048x1024'", "spp", "--spp=1"),
    ] {
        let refused = render(text, &[]);
        assert_eq!(refused.code, 2, "{text}: {}", refused.err);
        for word in ["scene.toml: key '", key, "--yes", &format!("--{key}")] {
            assert!(refused.err.contains(word), "{text}: '{word}' is not in: {}", refused.err);
        }
        let granted = render(text, &["--size=4x4", own]);
        assert!([0, 3].contains(&granted.code), "{text}: {}", granted.err);
    }
    // The file's own `yes` has no effect.
    assert_eq!(render("spp = 1000000000\nyes = true", &[]).code, 2);
    // An error limit alone ends at a stated time, and gives the image that it would give without the file.
    let said = render("error-limit = 0.5\nsize = '8x4'", &["--env-color=1,1,1", "-o", "a.hdr"]);
    assert!(said.code == 0 && said.err.contains("ends after 3600 s"), "{}", said.err);
    let own = render("size = '8x4'", &["--env-color=1,1,1", "-o", "b.hdr", "--error-limit=0.5"]);
    assert!(own.code == 0 && !own.err.contains("3600 s"), "{}", own.err);
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("a.hdr"), bytes("b.hdr"));
}

/// Layers requested by a file beside the scene are added to the image and do not replace it.
#[test]
fn a_file_beside_the_scene_leaves_out_no_picture() {
    let folder = folder_with(&triangle(|_, _| {}));
    fs::write(folder.path().join("scene.toml"), "size = '4x4'\nspp = 1\naov = ['depth', 'normal']").unwrap();
    dapple::well(folder.path(), &["render", "scene.gltf"]);
    assert_eq!(dapple::files(folder.path()), ["scene.exr", "scene.gltf", "scene.png", "scene.toml"]);
    fs::remove_file(folder.path().join("scene.png")).unwrap();
    dapple::well(folder.path(), &["render", "scene.gltf", "--aov", "depth"]);
    assert_eq!(dapple::files(folder.path()), ["scene.exr", "scene.gltf", "scene.toml"]);
}

/// Names and URIs come from files: whatever they contain, the terminal gets plain text of limited length.
#[test]
fn names_do_not_act_on_the_terminal() {
    let evil = format!("\u{1b}[2J\u{202e}\r\n\u{9b}\u{2028}\u{2029}{}", "x".repeat(100_000));
    let named = |root: &mut serde_json::Value| {
        for list in ["nodes", "meshes", "cameras", "materials"] {
            for thing in root[list].as_array_mut().into_iter().flatten() {
                thing["name"] = evil.as_str().into();
            }
        }
    };
    let spoiled = [
        triangle(|root, _| named(root)),
        triangle(|root, _| {
            named(root);
            root["meshes"][0]["primitives"][0]["indices"] = 99.into();
        }),
        triangle(|root, _| root["buffers"][0]["uri"] = evil.as_str().into()),
        triangle(|root, _| root["extensionsUsed"] = serde_json::json!([evil])),
        triangle(|root, _| {
            root["extensionsUsed"] = serde_json::json!([evil]);
            root["extensionsRequired"] = serde_json::json!([evil]);
        }),
    ];
    for scene in spoiled {
        let folder = folder_with(&scene);
        for command in ["render", "info", "plan", "replay"] {
            let more: &[&str] = match command {
                "render" => &["--size", "4x4", "--spp", "1"],
                "replay" => &["--pixel", "0,0", "--sample", "0"],
                _ => &[],
            };
            let run = run(folder.path(), &[&[command, "scene.gltf"], more].concat());
            assert!([0, 2].contains(&run.code), "{command}: {}", run.code);
            for text in [&run.out, &run.err] {
                let acts = |c: char| (c.is_control() && c != '\n') || "\u{202e}\u{2028}\u{2029}".contains(c);
                assert!(!text.contains(acts), "{command}: {:?}", text.chars().take(300).collect::<String>());
            }
            assert!(run.err.len() < 2000, "{command}: {} bytes", run.err.len());
        }
    }
}

/// The name of a file is chosen by whoever made it, and a line break in it would start a line of its own.
#[cfg(unix)]
#[test]
fn a_file_name_forges_no_line() {
    let folder = tempfile::tempdir().unwrap();
    let name = "a\nwarning: forged\u{2028}b.gltf";
    fs::write(folder.path().join(name), triangle(|_, _| {})).unwrap();
    fs::write(folder.path().join(name.replace("gltf", "toml")), "spp = 1\nsize = '4x4'\n").unwrap();
    for arguments in [&["info", name][..], &["render", name], &["plan", name]] {
        let run = run(folder.path(), arguments);
        assert_eq!(run.code, 0, "{}", run.err);
        let text = run.out + &run.err;
        assert!(
            !text.contains('\u{2028}') && !text.lines().any(|line| line.starts_with("warning: forged")),
            "{text}"
        );
    }
    let missing = run(folder.path(), &["render", "x\nwarning: forged.gltf"]);
    assert!(missing.code == 2 && missing.err.lines().count() == 1, "{}", missing.err);
}

#[test]
fn a_negative_number_is_named_with_its_option() {
    let folder = tempfile::tempdir().unwrap();
    for (option, wanted) in [
        ("--spp", "a positive number"),
        ("--threads", "a positive number"),
        ("--max-bounces", "a number that is not negative"),
        ("--seed", "a number that is not negative"),
    ] {
        let run = run(folder.path(), &["render", option, "-1"]);
        let said = format!("invalid value '-1' for '{option}': expected {wanted}");
        assert!(run.code == 2 && run.err.contains(&said), "{}", run.err);
    }
}

#[test]
fn a_missing_image_is_named_once_and_many_like_warnings_are_summed() {
    let scene = triangle(|root, _| {
        root["images"] = (0..40).map(|i| json!({ "uri": format!("gone{i}.png") })).collect();
        root["textures"] = (0..40).map(|i| json!({ "source": i })).collect();
        let texture = |i: i32| json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": i } } });
        root["materials"] = (0..40).map(texture).collect();
        let one = root["meshes"][0]["primitives"][0].clone();
        let primitive = |i: i32| {
            let mut primitive = one.clone();
            primitive["material"] = i.into();
            primitive
        };
        root["meshes"][0]["primitives"] = (0..40).map(primitive).collect();
    });
    let folder = folder_with(&scene);
    let small = ["render", "scene.gltf", "--size", "4x4", "--spp", "1", "--env-color", "1,1,1"];
    let lenient = run(folder.path(), &small);
    assert_eq!(lenient.code, 0, "{}", lenient.err);
    let about: Vec<&str> = lenient.err.lines().filter(|line| line.contains("gone")).collect();
    assert_eq!(about.len(), 5, "{}", lenient.err);
    assert!(about[4].ends_with("(and 35 more like this)"), "{}", about[4]);
    let strict = run(folder.path(), &[&small[..], &["--strict"]].concat());
    assert_eq!((strict.code, strict.err.matches("gone0.png").count()), (2, 1), "{}", strict.err);
}

/// Whoever words a message (the command line, the TOML or the JSON reader), it quotes at most 80 characters of a value.
#[test]
fn messages_repeat_the_beginning_of_a_value() {
    let long = "x".repeat(3000);
    let short = |said: &str| !said.contains(&long[..81]) && said.contains(&long[..70]);
    let of_json = [
        triangle(|root, _| root["nodes"][1]["translation"] = long.as_str().into()),
        triangle(|root, _| root["asset"]["version"] = long.as_str().into()),
        triangle(|root, _| root["nodes"][0]["mesh"] = long.as_str().into()),
    ];
    for scene in of_json {
        let folder = folder_with(&scene);
        let [render, info] = ["render", "info"].map(|command| run(folder.path(), &[command, "scene.gltf"]));
        assert!(render.code == 2 && short(&render.err), "{}", render.err);
        assert!(short(&format!("{}{}", info.out, info.err)), "{}{}", info.out, info.err);
    }
    let folder = folder_with(&triangle(|root, _| root["nodes"][1]["name"] = long.as_str().into()));
    let names = ["camera", "scene", "env", "size", "filter", "orbit", "tone", "pixel", "time-limit"];
    for name in names {
        fs::write(folder.path().join("scene.toml"), format!("{name} = '{long}y'")).unwrap();
        let run = run(folder.path(), &["render", "scene.gltf"]);
        assert!(run.code == 2 && short(&run.err), "{name}: {}", run.err);
    }
    fs::remove_file(folder.path().join("scene.toml")).unwrap();
    for text in [format!("{long} = 1"), format!("{long}.y = 1\n{long} = 2")] {
        fs::write(folder.path().join("mine.toml"), text).unwrap();
        let run = run(folder.path(), &["render", "scene.gltf", "--settings", "mine.toml"]);
        assert!(run.code == 2 && !run.err.contains(&long[..81]), "{}", run.err);
    }
}

/// A scene that is a device or a pipe is not read: reading might never end.
#[cfg(unix)]
#[test]
fn devices_are_no_scenes() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["info", "render"] {
        let run = run(folder.path(), &[command, "/dev/zero"]);
        assert!(
            run.code == 2 && run.err.contains("/dev/zero") && run.err.contains("regular file"),
            "{}",
            run.err
        );
    }
}

/// A name that no file system takes is rejected before the render.
#[test]
fn names_that_are_too_long_are_rejected_first() {
    let folder = tempfile::tempdir().unwrap();
    let name = format!("{}.png", "a".repeat(300));
    let run = run(folder.path(), &["render", "builtin:cornell", "--size", "8x8", "--spp", "1", "-o", &name]);
    assert!(run.code == 2 && !run.err.contains("rendered in"), "{}: {}", run.code, run.err);
    assert!(files(folder.path()).is_empty());
}
