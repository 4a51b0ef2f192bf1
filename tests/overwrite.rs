//! No command overwrites its inputs: a table of commands, inputs and output names.

mod dapple;

use dapple::{run, triangle};
use std::fs;
use std::path::{Path, PathBuf};

/// All inputs, in one folder.
const INPUTS: [&str; 10] = [
    "scene.gltf",
    "scene.toml",
    "mine.toml",
    "data.bin",
    "tex.png",
    "sky.hdr",
    "ref.exr",
    "report/scene-reference.exr",
    "report/scene-path-random-picture.exr",
    "report/scene-peer.exr",
];

const RENDER: &[&str] = &["render", "scene.gltf", "--env", "sky.hdr", "--settings", "mine.toml"];
const DIFF: &[&str] = &["diff", "tex.png", "ref.exr"];
const SHEET: &[&str] = &["sheet", "scene.gltf", "--vary", "pixel", "--counts", "1", "--reference", "ref.exr"];
const CONVERGE: &[&str] = &["converge", "scene.gltf", "--budget", "1s", "--seeds", "1"];

/// A folder with all inputs, and their original contents.
struct Table {
    folder: tempfile::TempDir,
    before: Vec<Vec<u8>>,
}

impl Table {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["sub", "report"] {
            fs::create_dir(at(name)).unwrap();
        }
        dapple::well(
            folder.path(),
            &["render", "--size", "4x4", "--spp", "1", "-o", "tex.png", "-o", "ref.exr"],
        );
        fs::copy(dapple::scene("sky.hdr"), at("sky.hdr")).unwrap();
        let scene = triangle(|root, buffer| {
            fs::write(at("data.bin"), buffer).unwrap();
            root["buffers"][0]["uri"] = "data.bin".into();
            root["images"] = serde_json::json!([{ "uri": "tex.png" }]);
            root["textures"] = serde_json::json!([{ "source": 0 }]);
        });
        fs::write(at("scene.gltf"), scene).unwrap();
        fs::write(at("scene.toml"), "size = '4x4'\nspp = 1\n").unwrap();
        fs::write(at("mine.toml"), "seed = 1\n").unwrap();
        for copy in &INPUTS[7..] {
            fs::copy(at("ref.exr"), at(copy)).unwrap();
        }
        let before = INPUTS.iter().map(|name| fs::read(at(name)).unwrap()).collect();
        Self { folder, before }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Checks that all inputs are unchanged.
    fn is_whole(&self, after: &[&str]) {
        for (input, bytes) in INPUTS.iter().zip(&self.before) {
            assert!(fs::read(self.at(input)).unwrap() == *bytes, "{after:?} changed {input}");
        }
    }

    /// Expects one line that names the file, and no written file.
    fn refused(&self, command: &[&str], more: &[&str], named: &str) {
        let all = [command, more].concat();
        let run = run(self.path(), &all);
        assert_eq!(run.code, 2, "{all:?}: {}", run.err);
        let line = run.err.lines().last().unwrap_or_default();
        assert!(line.contains(named) && line.contains("overwritten"), "{all:?}: {}", run.err);
        self.is_whole(&all);
    }
}

#[test]
fn outputs_that_are_inputs_are_refused() {
    let table = Table::new();
    for name in ["tex.png", "sky.hdr", "sub/../tex.png", "./tex.png"] {
        table.refused(RENDER, &["-o", name], name);
    }
    let whole = table.at("tex.png");
    table.refused(RENDER, &["-o", whole.to_str().unwrap()], "tex.png");
    for input in &INPUTS[..6] {
        table.refused(RENDER, &["-o", "new.png", "--log", input], input);
    }
    for name in ["tex.png", "ref.exr", "sub/../ref.exr"] {
        table.refused(DIFF, &["-o", name], name);
    }
    table.refused(SHEET, &["-o", "tex.png"], "tex.png");
    #[cfg(unix)]
    {
        fs::hard_link(table.at("tex.png"), table.at("hard.png")).unwrap();
        std::os::unix::fs::symlink("tex.png", table.at("soft.png")).unwrap();
        for name in ["hard.png", "soft.png"] {
            table.refused(RENDER, &["-o", name], name);
            table.refused(DIFF, &["-o", name], name);
            table.refused(SHEET, &["-o", name], name);
        }
    }
    // On a case-insensitive file system, other letter case leads to the same file.
    if table.at("TEX.PNG").is_file() {
        table.refused(RENDER, &["-o", "TEX.PNG"], "TEX.PNG");
    }
    dapple::well(table.path(), &[RENDER, &["-o", "new.png", "--log", "new.jsonl"]].concat());
    table.is_whole(RENDER);
}

/// A folder may contain inputs, but none under the name of an output.
#[test]
fn a_report_writes_over_nothing_that_it_reads() {
    let table = Table::new();
    let reference = "report/scene-reference.exr";
    table.refused(CONVERGE, &["-o", "report", "--reference", reference], "scene-reference.exr");
    table.refused(CONVERGE, &["-o", "sub/../report/", "--reference", reference], "scene-reference.exr");
    let picture = "report/scene-path-random-picture.exr";
    table.refused(CONVERGE, &["-o", "report", "--reference", picture], "scene-path-random-picture.exr");
    let peer = ["--external", "peer=false {spp} {out}"];
    let more = [&["-o", "report", "--reference", "report/scene-peer.exr"], &peer[..]].concat();
    table.refused(CONVERGE, &more, "scene-peer.exr");
    #[cfg(unix)]
    {
        // A link under the name of an output leads to an input of a second scene.
        fs::create_dir(table.at("linked")).unwrap();
        fs::hard_link(table.at("tex.png"), table.at("linked/other-reference.png")).unwrap();
        fs::write(table.at("other.gltf"), triangle(|_, _| {})).unwrap();
        let both = ["converge", "other.gltf", "scene.gltf", "--budget", "1s"];
        table.refused(&both, &["-o", "linked"], "other-reference.png");
        fs::hard_link(table.at("mine.toml"), table.at("sub/results.csv")).unwrap();
        table.refused(CONVERGE, &["-o", "sub", "--settings", "mine.toml"], "results.csv");
    }
    // A file with another name does not conflict, and is only read.
    fs::create_dir(table.at("fine")).unwrap();
    fs::copy(table.at("ref.exr"), table.at("fine/truth.exr")).unwrap();
    let fine = ["-o", "fine", "--reference", "fine/truth.exr", "--run", "a:", "--quiet"];
    dapple::well(table.path(), &[CONVERGE, &fine].concat());
    assert!(fs::read(table.at("fine/truth.exr")).unwrap() == table.before[6]);
    assert!(table.at("fine/report.html").is_file());
    table.is_whole(CONVERGE);
}

/// Commands without outputs accept or reject the options of a render; either way they write nothing.
#[test]
fn commands_that_print_write_nothing() {
    let table = Table::new();
    for command in [
        &["plan", "scene.gltf"][..],
        &["rays", "scene.gltf"],
        &["replay", "scene.gltf", "--pixel", "1,1", "--sample", "0"],
        &["budget", "scene.gltf", "--error-limit", "0.5", "--time-limit", "100ms"],
    ] {
        for more in [&["-o", "tex.png"][..], &["--log", "data.bin"], &["-o", "new.exr", "--log", "new.jsonl"]]
        {
            let all = [command, more].concat();
            run(table.path(), &all);
            table.is_whole(&all);
            assert!(!table.at("new.exr").exists() && !table.at("new.jsonl").exists(), "{all:?}");
        }
    }
    run(table.path(), &["info", "scene.gltf", "--json"]);
    table.is_whole(&["info"]);
}

/// Files with the names of a report that no comparison has written are kept.
#[test]
fn a_folder_with_other_reports_is_refused() {
    for name in ["report.html", "results.csv"] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(name), "mine").unwrap();
        let run = dapple::run(folder.path(), &["converge", "builtin:furnace", "--size", "4x4", "-o", "."]);
        assert!(run.code == 2 && run.err.contains(name) && run.err.contains("not written by"), "{}", run.err);
        assert_eq!(fs::read(folder.path().join(name)).unwrap(), b"mine");
    }
}
