//! Ctrl-C: the first one ends a render after the pass under way, the second one at once.
#![cfg(unix)]

mod dapple;

use dapple::files;
use dapple_imaging::read;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A render in `folder` that has begun: it says so with `-v`.
fn begun(folder: &Path, arguments: &[&str]) -> (Child, BufReader<impl Read>) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_dapple"))
        .args([&["render", "builtin:cornell", "-v", "--json"], arguments].concat())
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("rendering") {
        line.clear();
        assert_ne!(said.read_line(&mut line).unwrap(), 0, "it ended before it began");
    }
    (child, said)
}

fn interrupt(child: &Child) {
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

#[test]
fn once_keeps_whole_passes() {
    let folder = tempfile::tempdir().unwrap();
    let asked = 1_000_000;
    let (child, mut said) = begun(
        folder.path(),
        &["--size", "64x48", "--spp", "1000000", "--aov", "samples", "-o", "a.exr", "-o", "a.png"],
    );
    std::thread::sleep(Duration::from_millis(200));
    interrupt(&child);
    let output = child.wait_with_output().unwrap();
    let mut err = String::new();
    said.read_to_string(&mut err).unwrap();
    assert_eq!(output.status.code(), Some(3), "{err}");
    assert!(err.contains("stopped early"), "{err}");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let spp = json["spp"].as_u64().unwrap();
    assert!((1..asked).contains(&spp) && json["stopped"] == true, "{json}");
    assert_eq!(files(folder.path()), ["a.exr", "a.png"]);
    let layers = read::layers(&folder.path().join("a.exr")).unwrap();
    let samples = layers.layers.iter().find(|l| l.name == "samples").unwrap();
    assert!(
        samples.channels[0].1.iter().all(|&n| n == spp as f32),
        "pixels differ in their number of samples"
    );
}

#[test]
fn twice_ends_at_once() {
    let folder = tempfile::tempdir().unwrap();
    // One pass over this many pixels takes seconds.
    let (mut child, mut said) =
        begun(folder.path(), &["--size", "2048x1536", "--threads", "1", "-o", "a.exr"]);
    interrupt(&child);
    let mut line = String::new();
    said.read_line(&mut line).unwrap();
    assert!(line.contains("once more"), "{line}");
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(files(folder.path()).is_empty());
}
