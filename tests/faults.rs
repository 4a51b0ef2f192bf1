//! Faults during long renders: what is lost, and the exit code. `cargo test --test faults -- --nocapture` prints a table;
//! with `--ignored` as well, more processes are killed.
#![cfg(unix)]

mod dapple;

use dapple::{files, run, signal, well};
use std::fs;
use std::io::{BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::Duration;

/// A render of about a second, and the arguments with which a scheduler starts it again and again.
const RENDER: [&str; 9] =
    ["render", "builtin:cornell", "--size", "48x40", "--spp", "400", "--seed", "2", "--quiet"];
const AGAIN: [&str; 6] = ["--checkpoint", "c", "--resume", "c", "--checkpoint-every", "50ms"];

fn start(folder: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_dapple"))
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Starts a render that takes hours, and waits until it has begun.
fn endless(folder: &Path, more: &[&str]) -> (Child, BufReader<ChildStderr>) {
    let base = ["render", "builtin:cornell", "--size", "64x48", "--spp", "100000000", "-v"];
    let mut child = start(folder, &[&base[..], more].concat());
    let said = dapple::begun(&mut child);
    (child, said)
}

/// Waits up to a minute until `path` exists.
fn wait_for(path: &Path) {
    for _ in 0..1200 {
        if path.exists() {
            return;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    panic!("{} was not written", path.display());
}

/// Prints one row of the table.
fn row(fault: &str, tries: usize, lost: &str, code: &str) {
    println!("| {fault} | {tries} | {lost} | {code} |");
}

/// Kills a render `times` times without warning, at moments spread over its first `longest` milliseconds, and resumes
/// it each time.
fn kill(times: u64, longest: u64) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    well(path, &[&RENDER[..], &["-o", "whole.exr"]].concat());
    let mut killed = 0;
    for i in 0..times {
        let mut child = start(path, &[&RENDER[..], &AGAIN, &["-o", "a.exr"]].concat());
        std::thread::sleep(Duration::from_millis(20 + i * 7919 % longest));
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            killed += 1;
        }
        child.wait().unwrap();
    }
    well(path, &[&RENDER[..], &AGAIN, &["-o", "a.exr"]].concat());
    assert!(fs::read(path.join("a.exr")).unwrap() == fs::read(path.join("whole.exr")).unwrap());
    assert_eq!(files(path), ["a.exr", "c", "whole.exr"], "no temporary file is left");
    assert!(killed > 0);
    row("killed (SIGKILL) and resumed", killed, "samples since the last checkpoint", "-");
}

#[test]
fn killed_without_warning() {
    kill(6, 400);
}

#[test]
#[ignore = "long: 60 processes are killed"]
fn killed_without_warning_often() {
    kill(60, 900);
}

/// USR1 saves the image so far and a checkpoint; repeated TERM ends the render with both; a second process is refused.
#[test]
fn signals_and_a_second_process() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let own = ["-o", "a.exr", "-o", "a.png", "--checkpoint", "c"];
    let (child, mut said) = endless(path, &own);
    std::thread::sleep(Duration::from_millis(300));
    signal(&child, "-USR1");
    wait_for(&path.join("c"));
    wait_for(&path.join("a.partial.png"));
    assert!(!path.join("a.exr").exists() && !path.join("a.png").exists());
    dapple_imaging::read::layers(&path.join("a.partial.exr")).unwrap();
    let second = run(path, &[&RENDER[..], &["-o", "b.exr", "--checkpoint", "c"]].concat());
    assert!(second.code == 2 && second.err.contains("another process renders with this checkpoint"));
    row("two processes with one checkpoint", 1, "nothing", "2 of the second");
    signal(&child, "-TERM");
    signal(&child, "-TERM");
    let output = child.wait_with_output().unwrap();
    let mut err = String::new();
    said.read_to_string(&mut err).unwrap();
    assert_eq!(output.status.code(), Some(3), "{err}");
    assert!(err.contains("saved a.partial.png with unfinished:"), "{err}");
    assert_eq!(files(path), ["a.exr", "a.png", "c"]);
    row("SIGTERM, twice", 1, "samples of the unfinished pass", "3");
}

/// The image so far outlives a killed process, under a name of its own.
#[test]
fn the_image_so_far_stays() {
    let folder = tempfile::tempdir().unwrap();
    let (mut child, _said) = endless(folder.path(), &["-o", "a.exr", "--save-every", "100ms"]);
    wait_for(&folder.path().join("a.partial.exr"));
    child.kill().unwrap();
    child.wait().unwrap();
    let left = files(folder.path());
    assert!(left.contains(&"a.partial.exr".into()) && !left.contains(&"a.exr".into()), "{left:?}");
    dapple_imaging::read::layers(&folder.path().join("a.partial.exr")).unwrap();
    well(folder.path(), &["render", "--size", "8x8", "--spp", "1", "-o", "b.exr", "--save-every", "0"]);
    row("killed without a checkpoint", 1, "samples since the image so far", "-");
}

/// Under a limit of the file size, as on a full disk, the former checkpoint is kept and every loss is named.
#[test]
fn no_space() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    well(path, &[&RENDER[..], &["-o", "whole.exr"]].concat());
    let first = run(path, &[&RENDER[..], &AGAIN, &["-o", "a.exr", "--time-limit", "100ms"]].concat());
    assert_eq!(first.code, 3, "{}", first.err);
    let checkpoint = fs::read(path.join("c")).unwrap();
    let again = [&RENDER[..], &AGAIN, &["-o", "a.exr"]].concat().join(" ");
    let limited = format!("ulimit -f 2; exec '{}' {again}", env!("CARGO_BIN_EXE_dapple"));
    let found = Command::new("sh").args(["-c", &limited]).current_dir(path).output().unwrap();
    let err = String::from_utf8(found.stderr).unwrap();
    assert_eq!(found.status.code(), Some(4), "{err}");
    assert_eq!(err.matches("--checkpoint c: cannot be written").count(), 1, "{err}");
    assert!(err.contains("a.exr"), "{err}");
    assert!(fs::read(path.join("c")).unwrap() == checkpoint, "the former checkpoint is kept");
    row("no space for checkpoint and image", 1, "samples since the former checkpoint", "4");
    well(path, &[&RENDER[..], &AGAIN, &["-o", "a.exr"]].concat());
    assert!(fs::read(path.join("a.exr")).unwrap() == fs::read(path.join("whole.exr")).unwrap());
}

/// A log on a full disk ends neither the render nor the images.
#[test]
#[cfg(target_os = "linux")]
fn no_space_for_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let small = ["render", "--size", "8x8", "--spp", "4", "-o", "a.exr", "--log", "/dev/full"];
    let found = run(folder.path(), &small);
    assert!(found.code == 4 && found.err.contains("--log /dev/full: cannot be written"), "{}", found.err);
    assert_eq!(files(folder.path()), ["a.exr"]);
    row("no space for the log", 1, "the log", "4");
}

/// If the folder of an output disappears, the image is saved elsewhere and the checkpoint is not affected.
#[test]
fn the_folder_disappears() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::create_dir(path.join("out")).unwrap();
    let (child, mut said) = endless(path, &["-o", "out/a.exr", "--checkpoint", "c"]);
    fs::remove_dir(path.join("out")).unwrap();
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    let mut err = String::new();
    said.read_to_string(&mut err).unwrap();
    assert_eq!(output.status.code(), Some(4), "{err}");
    let saved = err.lines().find_map(|line| line.split_once("it is saved as ")).unwrap().1;
    dapple_imaging::read::layers(Path::new(saved)).unwrap();
    fs::remove_file(saved).unwrap();
    assert!(path.join("c").exists());
    row("output folder removed", 1, "nothing: the image is saved elsewhere", "4");
}

/// More threads than cores change nothing.
#[test]
fn many_threads() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |threads: &str| {
        well(folder.path(), &[&RENDER[..], &["-o", "a.exr", "--threads", threads]].concat());
        fs::read(folder.path().join("a.exr")).unwrap()
    };
    assert!(bytes("1") == bytes("64"));
    row("1 and 64 threads", 2, "nothing", "0");
}

/// A checkpoint that is truncated anywhere, or has a flipped bit, is refused, and stays as it is.
#[test]
fn damaged_checkpoints() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let small = ["render", "--size", "32x24", "--spp", "4", "--quiet", "-o", "a.exr"];
    well(path, &[&small[..], &["--checkpoint", "c"]].concat());
    let image = fs::read(path.join("a.exr")).unwrap();
    let whole = fs::read(path.join("c")).unwrap();
    let resume = |bytes: &[u8]| {
        fs::write(path.join("c"), bytes).unwrap();
        let found = run(path, &[&small[..], &["--resume", "c"]].concat());
        assert!(found.code == 0 || fs::read(path.join("c")).unwrap() == bytes);
        found.code
    };
    let cuts: Vec<usize> = (0..whole.len()).step_by(4096).collect();
    assert!(cuts.len() > 5 && cuts.iter().all(|length| resume(&whole[..*length]) == 2));
    row("checkpoint truncated at every 4 KiB", cuts.len(), "the checkpoint", "2");
    let flips = 40;
    for i in 0..flips {
        let mut flipped = whole.clone();
        let bit = (8 * whole.len() / flips) * i + 3;
        flipped[bit / 8] ^= 1 << (bit % 8);
        // A bit of the padding after the header means nothing.
        let is_same = || fs::read(path.join("a.exr")).unwrap() == image;
        assert!(resume(&flipped) == 2 || is_same(), "bit {bit}");
    }
    row("bit of a checkpoint flipped", flips, "the checkpoint", "2");
}

/// Parts of another scene, seed or version of the samples are not merged; neither are damaged ones.
#[test]
fn parts_that_do_not_belong_together() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let part = |name: &str, samples: &str, more: &[&str]| {
        let small = ["render", "--size", "8x8", "--spp", "8", "--quiet", "--samples", samples, "-o", name];
        well(path, &[&small[..], more].concat());
    };
    part("a.part", "0:4", &[]);
    part("b.part", "4:8", &["--seed", "1"]);
    part("c.part", "4:8", &["builtin:furnace"]);
    part("d.part", "4:8", &[]);
    let merge = |other: &str| run(path, &["merge", "a.part", other, "-o", "m.exr"]);
    for other in ["b.part", "c.part"] {
        let found = merge(other);
        assert!(found.code == 2 && found.err.contains("not of the same render as a.part"), "{}", found.err);
    }
    row("parts of other seeds and scenes", 2, "nothing", "2");
    let whole = fs::read(path.join("d.part")).unwrap();
    let cuts: Vec<usize> = (0..whole.len()).step_by(1 + whole.len() / 20).collect();
    for length in &cuts {
        fs::write(path.join("e.part"), &whole[..*length]).unwrap();
        assert_eq!(merge("e.part").code, 2);
    }
    row("part truncated", cuts.len(), "the part", "2");
    let bits = dapple_integrator::BITS;
    let at = find(&whole, format!("\"bits\":\"{bits}\"").as_bytes());
    let mut older = whole.clone();
    older[at + 8] = b'0';
    fs::write(path.join("e.part"), &older).unwrap();
    assert_eq!(merge("e.part").code, 2);
    row("part of another version of the samples", 1, "nothing", "2");
    assert_eq!(merge("d.part").code, 0);
}

/// Position of `word` in `bytes`.
fn find(bytes: &[u8], word: &[u8]) -> usize {
    bytes.windows(word.len()).position(|at| at == word).unwrap()
}

/// The clock of the system is read nowhere in a render, so that setting it does not change a time limit.
#[test]
fn the_clock_goes_backwards() {
    fn sources(folder: &Path, all: &mut Vec<String>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                sources(&path, all);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                all.push(fs::read_to_string(path).unwrap());
            }
        }
    }
    let mut all = Vec::new();
    ["integrator/src", "cli"].iter().for_each(|name| {
        sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("crates").join(name), &mut all);
    });
    assert!(all.len() > 100 && all.iter().any(|text| text.contains("Instant::now")));
    assert!(!all.iter().any(|text| text.contains("SystemTime")));
    row("clock set back under --time-limit", 1, "nothing: time is monotonic", "0");
}

/// A panic in one tile costs its pixels; the other pixels are rendered, and the failure is reported.
#[test]
fn a_panic_in_one_tile() {
    use dapple_integrator::scene::builtin::builtin;
    use dapple_integrator::{Integrator, Renderer, SampleContext, Settings};
    use std::sync::atomic::{AtomicBool, Ordering};
    /// Panics at its first sample.
    struct Broken(AtomicBool);
    impl Integrator for Broken {
        fn radiance(&self, _: &dapple_integrator::math::Ray, _: &SampleContext<'_>) -> glam::Vec3 {
            assert!(self.0.swap(true, Ordering::Relaxed), "an error of the program");
            glam::Vec3::ONE
        }
    }
    let scene = builtin("cornell").unwrap().build().unwrap();
    let settings = Settings { size: (48, 32), ..Settings::default() }.with_spp(2);
    let broken = Broken(AtomicBool::new(false));
    let mut renderer =
        Renderer::with_integrator(&scene, &scene.cameras[0].camera, &settings, &broken).unwrap();
    renderer.advance(2, &|_| std::ops::ControlFlow::Continue(()));
    let (outcome, part) = renderer.finish_with_part(dapple_integrator::Advance::Reached);
    let black = outcome.film.mean().pixels.iter().filter(|pixel| **pixel == glam::Vec3::ZERO).count();
    assert_eq!((outcome.stats.failures.len(), black), (1, 256));
    let covered: usize = part.unwrap().covered().iter().map(|covered| covered.rect.area()).sum();
    assert_eq!(covered, 48 * 32 - 256);
    row("panic in one tile", 1, "the 256 pixels of the tile", "4");
}
