//! Integration tests of the command line: written files and printed output, which do not depend on the machine.

mod dapple;

use dapple::{files, scene, triangle, well};
use dapple_imaging::{Image, Layers, read};
use std::fs;
use std::path::Path;

const SMALL: [&str; 4] = ["--size", "24x16", "--spp", "4"];

fn render(folder: &Path, more: &[&str]) -> dapple::Run {
    well(folder, &[&["render", "builtin:cornell"], &SMALL[..], more].concat())
}

fn layers(path: &Path) -> Layers {
    read::layers(path).unwrap()
}

/// Returns one channel of one layer; the beauty layer has no name.
fn channel<'a>(layers: &'a Layers, layer: &str, channel: &str) -> &'a [f32] {
    let layer = layers.layers.iter().find(|l| l.name == layer).unwrap();
    &layer.channels.iter().find(|(name, _)| name == channel).unwrap().1
}

#[test]
fn json_says_everything() {
    let folder = tempfile::tempdir().unwrap();
    let json = render(folder.path(), &["--json", "--seed", "7", "--threads", "1"]).json();
    for key in [
        "render_seconds",
        "load_seconds",
        "build_seconds",
        "samples",
        "rays",
        "mrays_per_second",
        "peak_memory_bytes",
        "bad_samples",
        "triangles",
        "lights",
        "kernel",
        "width",
        "height",
        "spp",
        "seed",
        "threads",
        "outputs",
    ] {
        assert!(json.get(key).is_some_and(|v| !v.is_null()), "{key} is missing: {json}");
    }
    assert_eq!(json["samples"], 24 * 16 * 4);
    assert_eq!((&json["width"], &json["height"], &json["spp"]), (&24.into(), &16.into(), &4.into()));
    assert_eq!((&json["seed"], &json["threads"], &json["bad_samples"]), (&7.into(), &1.into(), &0.into()));
    assert!(json["rays"].as_u64().unwrap() >= 24 * 16 * 4);
    assert_eq!(json["outputs"], serde_json::json!(["cornell.exr", "cornell.png"]));
}

#[test]
fn nothing_said_means_the_cornell_box() {
    let folder = tempfile::tempdir().unwrap();
    let run = well(folder.path(), &["render", "--size", "8x8", "--spp", "1"]);
    assert_eq!(run.out, "cornell.exr\ncornell.png\n");
    assert_eq!(files(folder.path()), ["cornell.exr", "cornell.png"]);
}

#[test]
fn what_is_quiet_and_what_is_help() {
    let folder = tempfile::tempdir().unwrap();
    let run = render(folder.path(), &["--quiet"]);
    assert_eq!(run.err, "");
    assert!(render(folder.path(), &[]).err.contains("24x16"));
    for arguments in [&["--help"][..], &["render", "--help"], &["--version"]] {
        let run = well(folder.path(), arguments);
        assert!(run.out.contains("dapple") && run.err.is_empty());
    }
}

#[test]
fn threads_and_place_change_no_byte() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let aov = ["--aov", "albedo,normal,depth,position,variance,samples,object,material,removed"];
    render(a.path(), &[&["--threads", "1"], &aov[..]].concat());
    render(b.path(), &[&["--threads", "2"], &aov[..]].concat());
    for name in ["cornell.exr", "cornell.png"] {
        let bytes = |folder: &Path| fs::read(folder.join(name)).unwrap();
        assert!(bytes(a.path()) == bytes(b.path()), "{name} differs");
    }
}

#[test]
fn another_seed_is_another_picture() {
    let folder = tempfile::tempdir().unwrap();
    render(folder.path(), &["-o", "a.exr", "--seed", "1"]);
    render(folder.path(), &["-o", "b.exr", "--seed", "2"]);
    let red = |name: &str| channel(&layers(&folder.path().join(name)), "", "R").to_vec();
    assert_ne!(red("a.exr"), red("b.exr"));
}

#[test]
fn a_crop_has_the_full_pictures_pixels() {
    let folder = tempfile::tempdir().unwrap();
    render(folder.path(), &["-o", "full.exr"]);
    render(folder.path(), &["-o", "part.exr", "--crop", "5,3,17,11"]);
    let (full, part) = (layers(&folder.path().join("full.exr")), layers(&folder.path().join("part.exr")));
    assert_eq!((part.width, part.height, part.offset, part.full_size), (12, 8, (5, 3), (24, 16)));
    for name in ["R", "G", "B"] {
        let (all, some) = (channel(&full, "", name), channel(&part, "", name));
        for y in 0..8 {
            let row = (y + 3) * 24 + 5;
            assert_eq!(all[row..row + 12], some[y * 12..(y + 1) * 12], "row {y} of {name}");
        }
    }
}

#[test]
fn every_format_holds_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    let run = render(folder.path(), &["-o", "a.exr", "-o", "a.hdr", "-o", "a.png", "--exposure", "0"]);
    assert_eq!(run.out, "a.exr\na.hdr\na.png\n");
    let read = |name: &str| read::picture(&folder.path().join(name)).unwrap();
    let exact = read("a.exr");
    let apart = |other: &Image, clip: f32| {
        let pairs = exact.pixels.iter().zip(&other.pixels);
        pairs.map(|(a, b)| (a.min(glam::Vec3::splat(clip)) - *b).abs().max_element()).fold(0.0, f32::max)
    };
    let brightest = exact.pixels.iter().fold(0.0, |m: f32, p| m.max(p.max_element()));
    assert!(apart(&read("a.hdr"), f32::MAX) <= brightest / 128.0);
    // Eight bits of sRGB: the largest step is below 1 %.
    assert!(apart(&read("a.png"), 1.0) < 0.01);
}

#[test]
fn half_floats_are_near() {
    let folder = tempfile::tempdir().unwrap();
    render(folder.path(), &["-o", "f.exr"]);
    render(folder.path(), &["-o", "h.exr", "--half"]);
    let read = |name: &str| channel(&layers(&folder.path().join(name)), "", "G").to_vec();
    for (full, half) in read("f.exr").into_iter().zip(read("h.exr")) {
        assert!((full - half).abs() <= full.abs() / 1024.0 + 1e-7, "{full} {half}");
    }
}

#[test]
fn exr_says_how_it_was_made() {
    let folder = tempfile::tempdir().unwrap();
    render(folder.path(), &["-o", "a.exr", "--threads", "1", "--seed", "5"]);
    let layers = layers(&folder.path().join("a.exr"));
    let keys: Vec<&str> = layers.metadata.iter().map(|(key, _)| key.as_str()).collect();
    for key in ["worldToCamera", "worldToNDC", "software", "bits", "spp", "seed", "settings"] {
        assert!(keys.contains(&key), "{key} is missing from {keys:?}");
    }
    let text = format!("{:?}", layers.metadata);
    assert!(text.contains("spp = 4") && text.contains("24x16"), "{text}");
    for kept_out in ["threads", "seconds", folder.path().to_str().unwrap()] {
        assert!(!text.contains(kept_out), "{kept_out} in {text}");
    }
}

#[test]
fn layers_are_what_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    render(folder.path(), &["-o", "a.exr", "--aov", "normal,depth,samples"]);
    let layers = layers(&folder.path().join("a.exr"));
    let mut names: Vec<&str> = layers.layers.iter().map(|l| l.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["", "depth", "normal", "samples"]);
    let samples = &layers.layers.iter().find(|l| l.name == "samples").unwrap().channels[0].1;
    assert!(samples.iter().all(|&n| n == 4.0));
}

#[test]
fn later_settings_win() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.gltf"), triangle(|_, _| {})).unwrap();
    fs::write(folder.path().join("scene.toml"), "spp = 2\nsize = '6x3'\nseed = 1\n").unwrap();
    fs::write(folder.path().join("mine.toml"), "seed = 2\nspp = 3\n").unwrap();
    let told = |more: &[&str]| {
        let json = well(folder.path(), &[&["render", "scene.gltf", "--json"], more].concat()).json();
        [&json["width"], &json["height"], &json["spp"], &json["seed"]].map(|v| v.as_u64().unwrap())
    };
    assert_eq!(told(&[]), [6, 3, 2, 1]);
    assert_eq!(told(&["--settings", "mine.toml"]), [6, 3, 3, 2]);
    assert_eq!(told(&["--settings", "mine.toml", "--seed", "9"]), [6, 3, 3, 9]);
}

#[test]
fn the_files_camera_gives_the_shape() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.gltf"), triangle(|_, _| {})).unwrap();
    let json = well(folder.path(), &["render", "scene.gltf", "--spp", "1", "--json"]).json();
    assert_eq!(json["width"].as_u64().unwrap(), 2 * json["height"].as_u64().unwrap());
}

#[test]
fn a_time_limit_ends_a_render() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["render", "builtin:cornell", "--size", "8x8", "--time-limit", "200ms", "--json"];
    let json = well(folder.path(), &arguments).json();
    assert!(json["spp"].as_u64().unwrap() >= 1);
    assert!(json["render_seconds"].as_f64().unwrap() < 20.0);
}

#[test]
fn replay_tells_the_same_sample() {
    let folder = tempfile::tempdir().unwrap();
    let shape = ["--size", "24x16", "--spp", "1", "--seed", "3"];
    well(folder.path(), &[&["render", "builtin:cornell", "-o", "a.exr"], &shape[..]].concat());
    let layers = layers(&folder.path().join("a.exr"));
    for (x, y) in [(12, 12), (4, 8), (20, 10), (0, 0)] {
        let pixel = format!("{x},{y}");
        let replay = ["replay", "builtin:cornell", "--pixel", &pixel, "--sample", "0", "--json"];
        let json = well(folder.path(), &[&replay[..], &shape].concat()).json();
        for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
            let rendered = f64::from(channel(&layers, "", name)[y * 24 + x]);
            let told = json["radiance"][i].as_f64().unwrap();
            assert!((rendered - told).abs() <= 1e-6 * rendered.abs(), "({x}, {y}) {name}: {rendered} {told}");
        }
        assert!(!json["vertices"].as_array().unwrap().is_empty());
    }
    let text = ["replay", "builtin:cornell", "--pixel", "12,12", "--sample", "0"];
    assert!(well(folder.path(), &[&text[..], &shape].concat()).out.contains("radiance"));
}

#[test]
fn info_says_what_is_in_a_file() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.gltf"), triangle(|_, _| {})).unwrap();
    for arguments in [&["info", "scene.gltf"][..], &["info", "builtin:cornell"]] {
        let text = well(folder.path(), arguments).out;
        assert!(text.contains("triangles") && text.contains("cameras"), "{text}");
        let json = well(folder.path(), &[arguments, &["--json"]].concat()).json();
        assert!(json["triangles"].as_u64().unwrap() >= 1);
    }
    assert_eq!(files(folder.path()), ["scene.gltf"]);
}

#[test]
fn a_reader_may_close_the_pipe() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_dapple"))
        .args(["info", "builtin:cornell"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"));
}

#[test]
fn scenes_of_the_repository_render() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = fs::read_dir(scene("")).unwrap().map(|e| e.unwrap().path());
    let mut count = 0;
    for path in scenes.filter(|p| p.extension().is_some_and(|e| e == "gltf")) {
        let arguments = ["render", path.to_str().unwrap(), "--size", "12x8", "--spp", "4", "--json"];
        let run = well(folder.path(), &arguments);
        // One scene demonstrates coincident lamps and gives a warning.
        let says = path.ends_with("coincident.gltf");
        assert_eq!(run.err.contains("warning"), says, "{}: {}", path.display(), run.err);
        assert_eq!(run.err.contains("remove the copies"), says, "{}: {}", path.display(), run.err);
        assert_eq!(run.json()["bad_samples"], 0, "{}", path.display());
        count += 1;
    }
    assert!(count >= 6);
}

/// A PNG without `--exposure` is metered on the whole frame: the printed option reproduces it, and crops, seeds and
/// sample counts do not change it.
#[test]
fn exposure_is_metered_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    let run = render(folder.path(), &["-o", "a.png", "-o", "a.exr", "--json"]);
    let stops = run.json()["exposure"].as_f64().unwrap() as f32;
    assert!(stops != 0.0 && run.err.contains(&format!("--exposure {stops} ")), "{}", run.err);
    let run = render(folder.path(), &["-o", "b.png", "-o", "b.exr", "--exposure", &stops.to_string()]);
    assert!(!run.err.contains("metered"));
    assert!(bytes("a.png") == bytes("b.png") && bytes("a.exr") == bytes("b.exr"));
    for more in [&["--crop", "3,2,5,4"][..], &["--seed", "9", "--pattern", "random", "--threads", "1"]] {
        let json = render(folder.path(), &[&["-o", "c.png", "--json"], more].concat()).json();
        assert_eq!(json["exposure"].as_f64().unwrap() as f32, stops, "{more:?}");
    }
    assert!(render(folder.path(), &["-o", "d.exr", "--json"]).json()["exposure"].is_null());
}

/// Intensities of lamps from Blender's exporter are divided by 683 lm/W, with a note; an option or the scene's settings
/// file can override this, and the image metadata records it.
#[test]
fn the_unit_of_lights_is_known_by_the_generator() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let lit = |generator: &str, intensity: f64| {
        triangle(|root, _| {
            root["asset"]["generator"] = generator.into();
            root["extensionsUsed"] = serde_json::json!(["KHR_lights_punctual"]);
            let light = serde_json::json!({ "type": "point", "intensity": intensity });
            root["extensions"] = serde_json::json!({ "KHR_lights_punctual": { "lights": [light] } });
            root["nodes"][1]["extensions"] = serde_json::json!({ "KHR_lights_punctual": { "light": 0 } });
        })
    };
    let blender = "Khronos glTF Blender I/O v4.2.60";
    fs::write(at("blender.gltf"), lit(blender, 683.0 * 20.0)).unwrap();
    fs::write(at("plain.gltf"), lit("by hand", 20.0)).unwrap();
    let size = ["--size", "12x8", "--spp", "4", "--env", "none", "--json", "-o"];
    let render = |scene: &str, name: &str, more: &[&str]| {
        let run = well(folder.path(), &[&["render", scene], &size[..], &[name], more].concat());
        let unit = run.json()["light_unit"].as_str().map(String::from);
        (fs::read(at(name)).unwrap(), read::picture(&at(name)).unwrap().mean().y, run.err, unit.unwrap())
    };
    let (_, plain, said, unit) = render("plain.gltf", "a.exr", &[]);
    assert!(plain > 0.001 && !said.contains("683") && unit == "radiometric", "{plain} {said}");
    let (bytes, mean, said, unit) = render("blender.gltf", "b.exr", &[]);
    assert!((mean / plain - 1.0).abs() < 1e-3 && unit == "photometric", "{mean} {plain}");
    assert!(said.contains("683 lm/W") && said.contains(blender) && said.contains("--light-unit"), "{said}");
    assert!(String::from_utf8_lossy(&bytes).contains("light-unit = \"photometric\""));
    let (_, bright, said, unit) = render("blender.gltf", "c.exr", &["--light-unit", "radiometric"]);
    assert!((bright / plain / 683.0 - 1.0).abs() < 1e-3 && !said.contains("683") && unit == "radiometric");
    fs::write(at("blender.toml"), "light-unit = 'radiometric'").unwrap();
    assert_eq!(render("blender.gltf", "d.exr", &[]).1, bright);
    let (_, dim, _, _) = render("plain.gltf", "e.exr", &["--light-unit", "photometric"]);
    assert!((plain / dim / 683.0 - 1.0).abs() < 1e-3);
    let info = |scene: &str| well(folder.path(), &["info", scene]).out;
    assert!(
        info("blender.gltf").contains("light unit: radiometric: "),
        "the settings file beside the scene overrides the unit"
    );
    fs::remove_file(at("blender.toml")).unwrap();
    assert!(info("blender.gltf").contains("light unit: photometric, divided by 683 lm/W: the generator"));
    assert!(info("plain.gltf").contains("light unit: radiometric: the generator 'by hand' is not known"));
    assert!(!well(folder.path(), &["info", "builtin:cornell"]).out.contains("light unit"));
}

/// The default light: added to a file without lights and to one whose own lights show almost nothing; never to a lit
/// scene, and never with `--env none`.
#[test]
fn a_file_that_would_be_black_is_lit() {
    let folder = tempfile::tempdir().unwrap();
    let size = ["--size", "24x16", "--spp", "4", "-o", "a.exr", "--aov", "beauty"];
    let mean = |scene: &str, more: &[&str]| {
        let run = well(folder.path(), &[&["render", scene], &size[..], more].concat());
        let picture = read::picture(&folder.path().join("a.exr")).unwrap();
        (picture.mean().y, run.err.contains("studio"))
    };
    // A second triangle behind the camera emits light; the first one faces away from it.
    let glowing = |root: &mut serde_json::Value| {
        root["materials"] = serde_json::json!([{}, { "emissiveFactor": [1, 1, 1] }]);
        let mut lamp = root["meshes"][0].clone();
        lamp["primitives"][0]["material"] = 1.into();
        root["meshes"].as_array_mut().unwrap().push(lamp);
        let lamp =
            serde_json::json!({ "mesh": 1, "translation": [0.2, 0.3, 0.5], "scale": [0.02, 0.02, 0.02] });
        root["nodes"].as_array_mut().unwrap().push(lamp);
        root["scenes"][0]["nodes"] = serde_json::json!([0, 1, 2]);
    };
    let write = |name: &str, scene: String| fs::write(folder.path().join(name), scene).unwrap();
    write("plain.gltf", triangle(|_, _| {}));
    write("glowing.gltf", triangle(|root, _| glowing(root)));
    for scene in ["plain.gltf", "glowing.gltf"] {
        let (lit, said) = mean(scene, &[]);
        assert!(lit > 0.1 && said, "{scene}: {lit}");
        let (dark, said) = mean(scene, &["--env", "none"]);
        assert!(dark < 0.01 && !said, "{scene}: {dark}");
        let (given, said) = mean(scene, &["--env-color", "0,0,0"]);
        assert!(given < 0.01 && !said, "{scene}: {given}");
    }
    for lit in ["builtin:cornell", "builtin:furnace"] {
        assert!(!mean(lit, &[]).1, "{lit}");
    }
    // The decision does not depend on how the render is sampled.
    let crop = ["--crop", "0,0,2,2", "--seed", "5", "--method", "distribution"];
    assert!(mean("glowing.gltf", &crop).1);
}
