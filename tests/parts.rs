//! Parts of a render: merged, they have the bytes of one render of all samples, wherever it was cut, and a part of
//! anything else is refused with the difference.

mod dapple;

use dapple::{run, scene, well};
use std::fs;
use std::path::{Path, PathBuf};

/// The bytes of a file in `folder`.
fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap()
}

/// Renders the parts `ranges` of the render with `arguments`; returns their names.
fn parts(folder: &Path, arguments: &[&str], ranges: &[&str]) -> Vec<String> {
    let one = |range: &&str| {
        let name = format!("{}.part", range.replace([':', '+'], "_"));
        well(folder, &[&["render"], arguments, &["--samples", range, "-o", &name, "--quiet"]].concat());
        name
    };
    ranges.iter().map(one).collect()
}

/// Merges `parts` to `out`.
fn merge(folder: &Path, parts: &[String], out: &str) {
    let names = parts.iter().map(String::as_str);
    let words = ["merge"].into_iter().chain(names).chain(["-o", out, "--quiet"]);
    well(folder, &words.collect::<Vec<_>>());
}

/// Asserts that the image of a render with `arguments` equals that of the merged parts.
fn same(arguments: &[&str], ranges: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    well(path, &[&["render"], arguments, &["-o", "whole.exr", "--quiet"]].concat());
    let mut parts = parts(path, arguments, ranges);
    // The order of the parts does not matter.
    parts.rotate_left(1);
    merge(path, &parts, "merged.exr");
    assert!(bytes(path, "whole.exr") == bytes(path, "merged.exr"), "{arguments:?}");
}

const ODD: [&str; 3] = ["0:7", "7:100", "100:256"];

fn all_scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|e| e == "gltf" || e == "glb");
    let mut all: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    all.retain(is_scene);
    all.sort();
    all
}

/// Asserts that merged parts of every scene have the bytes of the whole: path traced with all layers, adaptive, and by
/// the distribution tracer; of these settings, those that `takes` selects by the numbers of scene and settings.
fn of_every_scene(size: &str, takes: impl Fn(usize, usize) -> bool) {
    let scenes = all_scenes();
    assert!(scenes.len() >= 10);
    let tree = ["--method", "distribution", "--pixel", "4x4", "--light", "2", "--max-bounces", "3"];
    let all: [(&[&str], &[&str]); 4] = [
        (&["--spp", "256", "--aov", "all"], &ODD),
        (&["--spp", "256", "--adaptive"], &ODD),
        (&["--spp", "61", "--adaptive"], &["0:20", "20:61"]),
        (&tree, &["0:7", "7:+2", "9:16"]),
    ];
    for (i, file) in scenes.iter().enumerate() {
        let file = file.display().to_string();
        let small = [&file, "--size", size, "--seed", "5", "--yes", "--threads", "1"];
        for (_, (more, ranges)) in all.iter().enumerate().filter(|(j, _)| takes(i, *j)) {
            same(&[&small[..], more].concat(), ranges);
        }
    }
}

#[test]
fn merged_parts_have_the_bytes_of_the_whole() {
    of_every_scene("10x8", |i, j| i % 4 == j);
}

#[test]
#[ignore = "takes minutes"]
fn merged_parts_of_every_scene_and_method_have_the_bytes_of_the_whole() {
    of_every_scene("40x30", |_, _| true);
}

/// Every sampling pattern, biases, alpha, and many parts.
#[test]
fn all_settings_can_be_merged() {
    let at = |name: &str| scene(name).display().to_string();
    let (spheres, moving) = (at("cornell_spheres.gltf"), at("motion_blur.gltf"));
    let small = ["--size", "20x14", "--seed", "2"];
    let of = |more: &[&str], ranges: &[&str]| same(&[&small[..], more].concat(), ranges);
    of(
        &[&spheres, "--spp", "100", "--pattern", "random", "--clamp", "2", "--aov", "removed"],
        &["0:99", "99:100"],
    );
    of(&[&moving, "--spp", "64", "--pattern", "stratified", "--transparent"], &["0:7", "7:8", "8:64"]);
    of(&[&moving, "--spp", "12", "--pattern", "grid", "--aov", "cryptomatte"], &["0:5", "5:12"]);
    of(&[&spheres, "--spp", "12", "--max-bounces", "2"], &["0:1", "1:2", "2:5", "5:12"]);
    of(&[&spheres, "--aov", "albedo,normal", "--spp", "10"], &["0:3", "3:10"]);
    of(&[&spheres, "--crop", "3,2,17,9", "--spp", "20"], &["0:3", "3:20"]);
    // Without --spp the samples belong to a sequence.
    let folder = tempfile::tempdir().unwrap();
    let sobol = [&["render", &spheres], &small[..]].concat();
    well(folder.path(), &[&sobol[..], &["--spp", "48", "-o", "a.exr", "--quiet"]].concat());
    let parts = parts(folder.path(), &sobol[1..], &["0:3", "3:30", "30:48"]);
    merge(folder.path(), &parts, "b.exr");
    assert!(bytes(folder.path(), "a.exr") == bytes(folder.path(), "b.exr"));
}

/// Crops, also of adaptive renders, merge to the full frame, and larger parts are merged again.
#[test]
fn crops_and_merged_parts_are_merged() {
    for more in [&["--spp", "40"][..], &["--spp", "40", "--adaptive"]] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let arguments = [&["builtin:cornell", "--size", "30x24", "--aov", "samples,object"], more].concat();
        let of = |extra: &[&str]| well(path, &[&["render"], &arguments[..], &["--quiet"], extra].concat());
        of(&["-o", "whole.exr", "-o", "whole.png"]);
        of(&["--samples", "0:40", "--crop", "0,0,13,24", "-o", "left.part"]);
        of(&["--samples", "0:23", "--crop", "13,0,30,9", "-o", "top.part"]);
        of(&["--samples", "23:40", "--crop", "13,0,30,9", "-o", "top2.part"]);
        of(&["--samples", "0:23", "--crop", "13,9,30,24", "-o", "low.part"]);
        of(&["--samples", "23:40", "--crop", "13,9,30,24", "-o", "low2.part"]);
        let names = |all: &[&str]| all.iter().map(ToString::to_string).collect::<Vec<_>>();
        let some = ["merge", "top.part", "low.part", "top2.part", "-o", "some.part"];
        let gaps = run(path, &some);
        assert!(gaps.code == 2 && gaps.err.contains("samples 23:40 of pixels 13,9 to 30,24 are missing"));
        well(path, &[&some[..], &["--allow-gaps", "--quiet"]].concat());
        let gaps = run(path, &["merge", "some.part", "-o", "x.exr"]);
        assert!(gaps.code == 2 && gaps.err.contains("samples 23:40 of pixels 13,9 to 30,24 are missing"));
        merge(path, &names(&["low2.part", "some.part"]), "right.part");
        well(path, &["merge", "left.part", "right.part", "-o", "m.exr", "-o", "m.png", "--quiet"]);
        assert!(bytes(path, "whole.exr") == bytes(path, "m.exr"), "{more:?}");
        assert!(bytes(path, "whole.png") == bytes(path, "m.png"), "{more:?}");
    }
}

/// The error estimate and its bound are the same wherever the samples are divided, and agree with those of one render; the
/// bias report is that of one render.
#[test]
fn the_error_does_not_depend_on_the_parts() {
    let spheres = scene("cornell_spheres.gltf").display().to_string();
    let odd: [&str; 4] = ["0:7", "7:50", "50:64", "64:100"];
    let tree = ["--method", "distribution", "--pixel", "4x4", "--light", "2", "--max-bounces", "3", "--yes"];
    let all: [(&[&str], &str, &[&str]); 6] = [
        (&["--spp", "100"], "0:100", &odd),
        (&["--spp", "100", "--adaptive"], "0:100", &odd),
        (&["--spp", "100", "--pattern", "random", "--clamp", "3"], "0:100", &odd),
        (&["--spp", "64", "--pattern", "stratified", "--transparent"], "0:64", &odd[..3]),
        (&["--spp", "9"], "0:9", &["0:4", "4:9"]),
        (&tree, "0:16", &["0:7", "7:16"]),
    ];
    for (more, whole, ranges) in all {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let arguments = [&[&spheres[..], "--size", "24x20"], more].concat();
        let rendered = well(path, &[&["render"], &arguments[..], &["-o", "a.exr", "--json"]].concat()).json();
        let of = |ranges: &[&str]| {
            let parts = parts(path, &arguments, ranges);
            let names = parts.iter().map(String::as_str);
            let words: Vec<&str> =
                ["merge"].into_iter().chain(names).chain(["-o", "b.exr", "--json"]).collect();
            well(path, &words).json()
        };
        let (single, merged) = (of(&[whole]), of(ranges));
        for key in ["error_estimate", "error_bound", "error_reliable", "error_why"] {
            assert_eq!(single[key], merged[key], "{key} {more:?}");
        }
        for key in ["ledger", "samples", "rays"] {
            assert_eq!(rendered[key], merged[key], "{key} {more:?}");
        }
        let error = |of: &serde_json::Value| of["error_estimate"].as_f64().unwrap();
        // Half of the pixels of this small image are drawn, so that the estimates are close.
        assert!((0.6..1.6).contains(&(error(&merged) / error(&rendered))), "{more:?}");
    }
}

/// What does not belong together is told, and nothing is written.
#[test]
fn other_parts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("a.gltf"), dapple::triangle(|_, _| ())).unwrap();
    let render = |name: &str, more: &[&str]| {
        let small = ["render", "a.gltf", "--size", "8x8", "--env-color", "1,1,1", "--quiet", "-o", name];
        well(path, &[&small[..], more].concat());
    };
    render("a.part", &["--samples", "0:4", "--spp", "8"]);
    render("b.part", &["--samples", "4:8", "--spp", "8"]);
    let refused = |with: &[&str], said: &str| {
        let found = run(path, &[&["merge", "a.part"], with, &["-o", "x.exr"]].concat());
        assert!(found.code == 2 && found.err.contains(said), "{with:?}: {}", found.err);
        assert!(!path.join("x.exr").exists());
    };
    refused(&[], "samples 4:8 of pixels 0,0 to 8,8 are missing");
    refused(&["a.part", "b.part"], "samples 0:4 of pixels 0,0 to 8,8 are in another part too");
    refused(&["missing.part"], "cannot be read");
    refused(&["a.gltf"], "it is damaged");
    let other = |more: &[&str], said: &str| {
        render("o.part", &[&["--samples", "4:8"], more].concat());
        refused(&["o.part"], said);
    };
    other(&["--spp", "8", "--seed", "1"], "seed = 1 instead of seed = 0");
    other(&["--spp", "8", "--clamp", "3"], "clamp = 3");
    other(&["--spp", "8", "--aov", "depth"], "aov");
    other(&["--spp", "9"], "its set has 9 samples instead of 8");
    other(&["--spp", "8", "--pattern", "random"], "pattern = \"random\" instead of");
    let scene = fs::read_to_string(path.join("a.gltf")).unwrap();
    fs::write(path.join("a.gltf"), scene + "\n").unwrap();
    other(&["--spp", "8"], "files of the scene have changed: 'a.gltf'");
    well(path, &["render", "--size", "8x8", "--samples", "4:8", "--spp", "8", "--quiet", "-o", "o.part"]);
    refused(&["o.part"], "it belongs to the scene");
    // A part is not overwritten by the image.
    let found = run(path, &["merge", "a.part", "b.part", "-o", "b.part"]);
    assert!(found.code == 2 && found.err.contains("would be overwritten"), "{}", found.err);
    well(path, &["merge", "a.part", "--allow-gaps", "-o", "x.exr", "--quiet"]);
}

/// Truncated parts, and parts with any flipped bit, are refused or unchanged.
#[test]
fn damaged_parts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let small = ["render", "--size", "4x4", "--quiet", "--samples", "0:4", "--spp", "4", "-o", "a.part"];
    well(path, &small);
    well(path, &["merge", "a.part", "-o", "a.exr", "--quiet"]);
    let (part, image) = (bytes(path, "a.part"), bytes(path, "a.exr"));
    let try_it = |bytes: &[u8]| {
        fs::write(path.join("b.part"), bytes).unwrap();
        let found = run(path, &["merge", "b.part", "-o", "b.exr", "--quiet"]);
        assert!([0, 2].contains(&found.code), "{} {}", found.code, found.err);
        let is_same = || found.code == 0 && fs::read(path.join("b.exr")).unwrap() == image;
        assert!(found.code == 2 || is_same());
        found.code
    };
    let cuts = (0..16).map(|i| part.len() * i / 16);
    assert!(cuts.map(|length| try_it(&part[..length])).all(|code| code == 2));
    for i in 0..48 {
        let mut flipped = part.clone();
        let bit = (8 * part.len() / 48) * i + i % 8;
        flipped[bit / 8] ^= 1 << (bit % 8);
        try_it(&flipped);
    }
}

/// Ranges that cannot be rendered are refused before the scene is loaded, with the option to use.
#[test]
fn wrong_ranges_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |more: &[&str], said: &str| {
        let found = run(folder.path(), &[&["render", "--size", "8x8", "-o", "x.part"], more].concat());
        assert!(found.code == 2 && found.err.contains(said), "{more:?}: {}", found.err);
    };
    refused(&["--samples", "64"], "--spp");
    refused(&["--samples", "4:4"], "END is not included");
    refused(&["--samples", "0:8", "--spp", "4"], "there are only 4 samples");
    refused(&["--samples", "0:8", "--pattern", "stratified"], "--spp");
    refused(&["--samples", "0:8", "--error-limit", "0.1"], "--error-limit");
    refused(&["--samples", "0:17", "--method", "distribution", "--pixel", "4x4"], "only 16 samples");
    refused(&["--error-limit", "0.1"], "--error-limit");
    assert!(fs::read_dir(folder.path()).unwrap().next().is_none());
}

/// The image of missing samples is that of the others, and it is said.
#[test]
fn gaps_are_allowed_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let render = |name: &str, samples: &str| {
        let small = ["render", "--size", "8x8", "--spp", "16", "--quiet", "--samples", samples, "-o", name];
        well(path, &small);
    };
    render("a.part", "0:4");
    render("b.part", "8:12");
    let found =
        run(path, &["merge", "a.part", "b.part", "--allow-gaps", "-o", "ab.exr", "-o", "ab.part", "--json"]);
    assert_eq!(found.code, 0, "{}", found.err);
    assert!(found.err.contains("samples 4:8 of pixels 0,0 to 8,8, 12:16 of pixels 0,0 to 8,8 are missing"));
    assert_eq!((found.json()["spp"].as_u64(), found.json()["samples"].as_u64()), (Some(8), Some(512)));
    // The missing ones can still be added.
    render("c.part", "4:8");
    render("d.part", "12:16");
    well(path, &["merge", "ab.part", "d.part", "c.part", "-o", "all.exr", "--quiet"]);
    well(path, &["render", "--size", "8x8", "--spp", "16", "--quiet", "-o", "whole.exr"]);
    assert!(bytes(path, "all.exr") == bytes(path, "whole.exr"));
}

/// A part that is stopped continues from its checkpoint; without one the samples so far are a part under another name.
#[cfg(unix)]
#[test]
fn stopped_parts_are_continued() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let small = ["render", "--size", "64x64", "--spp", "4000", "--seed", "7"];
    let stopped = |more: &[&str]| {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_dapple"))
            .args([&small[..], &["--samples", "10:2000", "-o", "a.part", "-v"], more].concat())
            .current_dir(path)
            .stderr(std::process::Stdio::piped())
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        let said = dapple::begun(&mut child);
        std::thread::sleep(std::time::Duration::from_millis(400));
        dapple::signal(&child, "-TERM");
        let rest: String = std::io::Read::bytes(said).map_while(Result::ok).map(char::from).collect();
        assert_eq!(child.wait().unwrap().code(), Some(3), "{rest}");
        assert!(!path.join("a.part").exists());
        rest
    };
    let said = stopped(&["--checkpoint", "c", "--resume", "c"]);
    assert!(said.contains("the part is not written: --resume continues it"), "{said}");
    let resume = ["--samples", "10:2000", "-o", "a.part", "--checkpoint", "c", "--resume", "c", "--quiet"];
    well(path, &[&small[..], &resume].concat());
    fs::rename(path.join("a.part"), path.join("resumed.part")).unwrap();
    well(path, &[&small[..], &["--samples", "10:2000", "-o", "once.part", "--quiet"]].concat());
    let image = |part: &str| {
        well(path, &["merge", part, "--allow-gaps", "-o", "x.exr", "--quiet"]);
        bytes(path, "x.exr")
    };
    assert!(image("resumed.part") == image("once.part"));
    stopped(&[]);
    let gaps = run(path, &["merge", "a.partial.part", "-o", "x.exr"]);
    assert!(gaps.code == 2 && gaps.err.contains("samples 0:10 of pixels"), "{}", gaps.err);
}

/// The ranges of a plan are the whole, in order, for every frame.
#[test]
fn plans_divide_all_samples() {
    let folder = tempfile::tempdir().unwrap();
    let plan =
        |more: &[&str]| well(folder.path(), &[&["plan", "builtin:cornell", "--json"], more].concat()).json();
    let slices = plan(&["--slices", "8", "--spp", "100"]);
    let slices = slices["slices"].as_array().unwrap();
    let number = |slice: &serde_json::Value, key: &str| slice[key].as_u64().unwrap();
    assert_eq!((slices.len(), number(&slices[0], "begin"), number(&slices[7], "end")), (8, 0, 100));
    assert!(slices.windows(2).all(|pair| pair[0]["end"] == pair[1]["begin"]));
    let frames = plan(&["--slices", "2", "--spp", "8", "--frames", "3:6"]);
    let frames: Vec<i64> =
        frames["slices"].as_array().unwrap().iter().map(|s| s["frame"].as_i64().unwrap()).collect();
    assert_eq!(frames, [3, 3, 4, 4, 5, 5]);
    let lines = well(folder.path(), &["plan", "builtin:cornell", "--slices", "2", "--spp", "32"]).out;
    assert_eq!(lines, "--samples 0:24\n--samples 24:32\n");
    // The options of the render may all be given.
    let more = ["--slices", "2", "--spp", "32", "--half", "--checkpoint", "c", "-o", "a.part", "--quiet"];
    assert_eq!(well(folder.path(), &[&["plan", "builtin:cornell"], &more[..]].concat()).out, lines);
    let few = run(folder.path(), &["plan", "builtin:cornell", "--slices", "9", "--spp", "8"]);
    assert!(few.code == 2 && few.err.contains("only 8 samples"), "{}", few.err);
}
