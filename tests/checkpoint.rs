//! Checkpoints: a render that is interrupted and resumed has the bytes of an uninterrupted one, and a checkpoint of
//! anything else is refused with the difference.
#![cfg(unix)]

mod dapple;

use dapple::{files, run, scene, well};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Renders with `arguments` and the further ones, and returns the bytes of `a.exr`.
fn image(folder: &Path, arguments: &[&str], more: &[&str]) -> Vec<u8> {
    well(folder, &[&["render"], arguments, &["-o", "a.exr", "--quiet"], more].concat());
    fs::read(folder.join("a.exr")).unwrap()
}

/// Interrupts the render with `arguments` after each of `times`, in milliseconds, and resumes it; returns the bytes of
/// `a.exr`, and how often it was interrupted.
fn interrupted(folder: &Path, arguments: &[&str], times: &[u64]) -> (Vec<u8>, usize) {
    let base = [&["render"], arguments, &["-o", "a.exr", "--checkpoint", "c", "--resume", "c"]].concat();
    let mut count = 0;
    for (i, time) in times.iter().enumerate() {
        let threads = if i % 2 == 0 { "1" } else { "2" };
        let mut child = Command::new(env!("CARGO_BIN_EXE_dapple"))
            .args([&base[..], &["--threads", threads, "--quiet"]].concat())
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(*time));
        let sent =
            Command::new("kill").args(["-INT", &child.id().to_string()]).stderr(Stdio::null()).status();
        assert!(sent.is_ok());
        let code = child.wait().unwrap().code();
        // Without a code, the signal came before the program listened to it.
        assert!([Some(0), Some(3), None].contains(&code), "{code:?}");
        count += usize::from(code == Some(3));
    }
    let found = run(folder, &base);
    assert_eq!(found.code, 0, "{}", found.err);
    assert!(folder.join("c").exists() && !folder.join("c.lock").exists());
    (fs::read(folder.join("a.exr")).unwrap(), count)
}

/// Both tracers, adaptive sampling, layers, every sampling pattern, and scenes with motion, media and fireflies.
#[test]
fn a_resumed_render_has_the_same_bytes() {
    let at = |name: &str| scene(name).display().to_string();
    let (spheres, moving, nested) =
        (at("cornell_spheres.gltf"), at("motion_blur.gltf"), at("nested_media.gltf"));
    let tree = ["--method", "distribution", "--light", "4x4", "--pixel", "4x4", "--yes"];
    let mut total = 0;
    for arguments in [
        &["builtin:cornell", "--spp", "200", "--aov", "all"][..],
        &["builtin:cornell", "--spp", "300", "--adaptive", "--aov", "variance,samples"],
        &[&spheres, "--spp", "200", "--pattern", "random", "--clamp", "2", "--aov", "removed"],
        &[&moving, "--spp", "225", "--pattern", "stratified", "--transparent"],
        &[&nested, "--spp", "100", "--max-bounces", "5"],
        &[&["builtin:cornell"], &tree[..]].concat(),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let arguments = [&["--size", "48x40", "--seed", "3"], arguments].concat();
        let whole = image(folder.path(), &arguments, &[]);
        let (resumed, times) = interrupted(folder.path(), &arguments, &[20, 35, 60, 90]);
        assert!(whole == resumed, "{arguments:?}");
        total += times;
    }
    assert!(total >= 4, "only {total} renders were interrupted");
}

/// A render that ends by its error takes the same samples and states the same error, however often it is interrupted.
#[test]
fn the_error_limit_is_reached_at_the_same_samples() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["builtin:cornell", "--size", "32x32", "--error-limit", "0.08", "--json"];
    let base = [&["render", "-o", "a.exr"], &arguments[..]].concat();
    let whole = well(folder.path(), &base).json();
    let bytes = fs::read(folder.path().join("a.exr")).unwrap();
    let (resumed, _) = interrupted(folder.path(), &arguments, &[40, 80, 150]);
    assert!(bytes == resumed);
    let again = well(folder.path(), &[&base[..], &["--resume", "c"]].concat()).json();
    for key in ["spp", "rays", "error_estimate", "error_bound", "error_reliable", "ledger"] {
        assert_eq!(whole[key], again[key], "{key}");
    }
    assert!(bytes == fs::read(folder.path().join("a.exr")).unwrap());
}

/// What a checkpoint does not belong to is named, and nothing is overwritten.
#[test]
fn other_renders_do_not_resume() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let small = ["render", "a.gltf", "--size", "8x8", "--env-color", "1,1,1", "-o", "a.exr"];
    fs::write(path.join("a.gltf"), dapple::triangle(|_, _| ())).unwrap();
    let of = |more: &[&str]| run(path, &[&small[..], more].concat());
    assert_eq!(of(&["--spp", "4", "--checkpoint", "c"]).code, 0);
    let checkpoint = fs::read(path.join("c")).unwrap();
    let refused = |more: &[&str], said: &str| {
        let found = of(more);
        assert!(found.code == 2 && found.err.contains(said), "{more:?}: {}", found.err);
        assert!(fs::read(path.join("c")).unwrap() == checkpoint);
    };
    refused(&["--spp", "4", "--checkpoint", "c"], "the file exists; continue with --resume c");
    refused(&["--spp", "4", "--resume", "d"], "--resume d: cannot be read");
    refused(&["--spp", "8", "--resume", "c"], "now spp = 8 instead of spp = 4");
    refused(&["--spp", "4", "--resume", "c", "--seed", "1"], "now seed = 1 instead of seed = 0");
    refused(&["--spp", "4", "--resume", "c", "--aov", "depth"], "aov = \"depth\" instead of aov = \"\"");
    refused(&["--spp", "4", "--resume", "c", "--clamp", "3"], "now clamp = 3");
    let random = ["--pattern", "random", "--spp"];
    assert_eq!(of(&[&random[..], &["4", "--checkpoint", "r"]].concat()).code, 0);
    refused(&[&random[..], &["2", "--resume", "r"]].concat(), "it has 4 samples per pixel, more than the 2");
    fs::remove_file(path.join("r")).unwrap();
    refused(&["--spp", "4", "--resume", "c", "-o", "c"], "unknown image format");
    refused(&["--spp", "4", "--resume", "a.gltf"], "--resume");
    refused(&["--spp", "4", "--checkpoint", "a.gltf"], "exists");
    refused(&["--spp", "4", "--checkpoint", "none/c"], "none");
    let other = run(path, &["render", "--size", "8x8", "--spp", "4", "-o", "b.exr", "--resume", "c"]);
    assert!(
        other.code == 2 && other.err.contains("it belongs to the scene 'a', not 'cornell'"),
        "{}",
        other.err
    );
    fs::write(path.join("a.gltf"), dapple::triangle(|root, _| root["asset"]["generator"] = "x".into()))
        .unwrap();
    refused(&["--spp", "4", "--resume", "c"], "files of the scene have changed: 'a.gltf'");
    assert_eq!(files(path), ["a.exr", "a.gltf", "c"]);
}

/// A damaged checkpoint is refused: one that is cut at every 4 KiB, and ones with flipped bits.
#[test]
fn damage_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let base = ["render", "--size", "24x20", "--spp", "3", "-o", "a.exr"];
    well(path, &[&base[..], &["--checkpoint", "c"]].concat());
    let whole = fs::read(path.join("c")).unwrap();
    let cuts = (0..whole.len()).step_by(4096).map(|n| whole[..n].to_vec());
    let flips = (0..24).map(|i| {
        let mut bytes = whole.clone();
        let bit = (i * 7919 + 64) * 8 * whole.len() / (24 * 7919 + 64);
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes
    });
    for bytes in cuts.chain(flips).filter(|bytes| *bytes != whole) {
        fs::write(path.join("c"), &bytes).unwrap();
        let found = run(path, &[&base[..], &["--resume", "c"]].concat());
        assert!(found.code == 2 && found.err.contains("--resume c: "), "{}: {}", bytes.len(), found.err);
        assert!(fs::read(path.join("c")).unwrap() == bytes, "a damaged checkpoint is left to its owner");
    }
    fs::write(path.join("c"), &whole).unwrap();
    well(path, &[&base[..], &["--resume", "c"]].concat());
}
