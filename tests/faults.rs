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
