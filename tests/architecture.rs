//! Checks the layering of the crates: reads the manifests and fails if a dependency points upwards, if a crate has no
//! short README, or if a command at the root would omit a crate.

use std::fs;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Level of a package, which may depend only on strictly lower ones. `testkit` is outside the layering: it depends on
/// none of the crates, and only tests may use it.
fn level(package: &str) -> Option<u32> {
    match package.strip_prefix("dapple-").unwrap_or(package) {
        "math" => Some(0),
        "sampling" | "geometry" | "imaging" => Some(1),
        "materials" | "lights" | "camera" => Some(2),
        "scene" => Some(3),
        "integrator" => Some(4),
        "analysis" => Some(5),
        "verify" => Some(6),
        "dapple" => Some(7),
        _ => None,
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

fn manifest(folder: &Path) -> Table {
    let path = folder.join("Cargo.toml");
    fs::read_to_string(&path).unwrap().parse().unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Folders under `crates/` that are packages.
fn packages() -> Vec<PathBuf> {
    let mut folders: Vec<_> = fs::read_dir(root().join("crates"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.join("Cargo.toml").is_file())
        .collect();
    folders.sort();
    assert!(folders.len() >= 9, "the crates have moved");
    folders
}

fn name(manifest: &Table) -> String {
    manifest["package"]["name"].as_str().unwrap().to_string()
}

fn dapple_dependencies(manifest: &Table, section: &str) -> Vec<String> {
    let table = manifest.get(section).and_then(Value::as_table);
    let names = table.into_iter().flat_map(|t| t.keys().cloned());
    names.filter(|name| name.starts_with("dapple")).collect()
}

/// Dependencies of one manifest that do not point downwards.
fn arrows_up(manifest: &Table) -> Vec<String> {
    let from = name(manifest);
    let height = |package: &str| level(package).map_or(-1, i64::from);
    let mut wrong = Vec::new();
    for section in ["dependencies", "build-dependencies", "dev-dependencies"] {
        for to in dapple_dependencies(manifest, section) {
            let kit = to == "dapple-testkit";
            let down = if kit { section == "dev-dependencies" } else { height(&to) < height(&from) };
            if !down || (level(&to).is_none() && !kit) {
                wrong.push(format!("{from} → {to} ({section})"));
            }
        }
    }
    wrong
}

#[test]
fn arrows_go_down() {
    let manifests = packages().iter().map(|p| manifest(p)).chain([manifest(&root())]).collect::<Vec<_>>();
    let wrong: Vec<_> = manifests.iter().flat_map(arrows_up).collect();
    assert!(wrong.is_empty(), "dependencies that do not point downwards: {wrong:#?}");
    for m in &manifests {
        let package = name(m);
        assert!(
            level(&package).is_some() || package == "dapple-testkit",
            "{package}: add its level to this test"
        );
    }
}

#[test]
fn an_arrow_up_is_seen() {
    let parse = |text: &str| text.parse::<Table>().unwrap();
    for (text, up) in [
        ("[package]\nname='dapple-sampling'\n[dependencies]\ndapple-scene.workspace=true", true),
        ("[package]\nname='dapple-lights'\n[dependencies]\ndapple-materials.workspace=true", true),
        ("[package]\nname='dapple-geometry'\n[dev-dependencies]\ndapple-imaging.workspace=true", true),
        ("[package]\nname='dapple-scene'\n[dependencies]\ndapple-testkit.workspace=true", true),
        ("[package]\nname='dapple-testkit'\n[dependencies]\ndapple-sampling.workspace=true", true),
        ("[package]\nname='dapple-lights'\n[dependencies]\ndapple-unheard-of.workspace=true", true),
        ("[package]\nname='dapple-scene'\n[dependencies]\ndapple-lights.workspace=true", false),
        ("[package]\nname='dapple-scene'\n[dev-dependencies]\ndapple-testkit.workspace=true", false),
    ] {
        assert_eq!(!arrows_up(&parse(text)).is_empty(), up, "{text}");
    }
}

#[test]
fn every_crate_has_a_short_readme_with_an_example() {
    for folder in packages() {
        let readme = folder.join("README.md");
        let text = fs::read_to_string(&readme).unwrap_or_else(|e| panic!("{}: {e}", readme.display()));
        let lines = text.lines().count();
        assert!(lines <= 40, "{}: {lines} lines, at most 40", readme.display());
        assert!(text.contains("```rust"), "{}: no example in Rust", readme.display());
        let library = fs::read_to_string(folder.join("src/lib.rs")).unwrap();
        assert!(
            library.contains("README.md"),
            "{}: the example is not compiled; include the README in a doctest",
            readme.display()
        );
    }
}

#[test]
fn every_command_at_the_root_means_every_crate() {
    let root_manifest = manifest(&root());
    let list = |key: &str| -> Vec<String> {
        let items = root_manifest["workspace"][key].as_array().unwrap();
        items.iter().map(|v| v.as_str().unwrap().to_string()).collect()
    };
    let folders = packages();
    let mut expected: Vec<String> = folders
        .iter()
        .map(|p| p.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/"))
        .chain([".".to_string()])
        .collect();
    expected.sort();
    for key in ["members", "default-members"] {
        let mut listed = list(key);
        listed.sort();
        assert_eq!(listed, expected, "workspace.{key}");
    }
}

/// Files and folders of `crates` that may contain `unsafe` code, as listed in ARCHITECTURE.md, "Invariants".
const UNSAFE: [&str; 9] = [
    "cli/standard_output.rs",
    "geometry/src/bvh/memory.rs",
    "geometry/src/bvh/simd/",
    "geometry/src/bvh/stack.rs",
    "math/src/lanes/avx2.rs",
    "math/src/lanes/avx2_double.rs",
    "math/src/lanes/avx512.rs",
    "math/src/lanes/avx512_double.rs",
    "math/src/lanes/dispatch.rs",
];

/// Whether a source file contains `unsafe` code, or allows it.
fn has_unsafe(source: &str) -> bool {
    let code = source.lines().map(|line| line.split("//").next().unwrap_or_default());
    let forbids = |line: &str| line.contains("forbid(unsafe_code)") || line.contains("deny(unsafe_code)");
    code.filter(|line| !forbids(line)).any(|line| line.contains("unsafe"))
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let rust = files.into_iter().filter(|path| path.extension().is_some_and(|e| e == "rs"));
    rust.chain(folders.iter().flat_map(|folder| rust_files(folder))).collect()
}

#[test]
fn unsafe_code_stays_where_it_is_listed() {
    let crates = root().join("crates");
    let mut seen = Vec::new();
    for file in rust_files(&crates) {
        let name = file.strip_prefix(&crates).unwrap().to_string_lossy().replace('\\', "/");
        if has_unsafe(&fs::read_to_string(&file).unwrap()) {
            let listed = UNSAFE.iter().find(|place| name.starts_with(**place));
            seen.push(*listed.unwrap_or_else(|| panic!("{name}: unsafe code outside of the listed files")));
        }
    }
    for place in UNSAFE {
        assert!(seen.contains(&place), "{place}: no unsafe code there any more; shorten the list");
    }
    for folder in packages() {
        let library = fs::read_to_string(folder.join("src/lib.rs")).unwrap();
        let denied = library.contains("#![deny(unsafe_code)]");
        let may = folder.ends_with("geometry") || folder.ends_with("math");
        let forbidden = library.contains("#![forbid(unsafe_code)]");
        assert!(forbidden || (may && denied), "{}: forbid(unsafe_code) is missing", folder.display());
    }
}

#[test]
fn unsafe_code_is_seen() {
    assert!(has_unsafe("fn f() { unsafe { g() } }") && has_unsafe("#![allow(unsafe_code)]"));
    assert!(!has_unsafe("#![forbid(unsafe_code)]\n// unsafe\nfn f() {}"));
}

/// Examples of all crates are compiled into one folder, where equal names would overwrite each other.
#[test]
fn examples_have_names_of_their_own() {
    let packages = packages().into_iter().chain([root()]);
    let mut names: Vec<_> = packages
        .filter_map(|package| fs::read_dir(package.join("examples")).ok())
        .flat_map(|entries| entries.map(|entry| entry.unwrap().path().file_stem().unwrap().to_owned()))
        .collect();
    names.sort();
    assert!(names.len() > 10 && names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
}
