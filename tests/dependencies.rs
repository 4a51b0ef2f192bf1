//! Checks the direct dependencies of every crate, with and without default features.

use std::path::Path;
use std::process::Command;

/// Crate, its dependencies without default features, and those that the default features add.
const PINNED: [(&str, &[&str], &[&str]); 12] = [
    ("dapple-math", &["glam", "libm"], &[]),
    ("dapple-sampling", &["dapple-math", "glam", "libm"], &[]),
    ("dapple-geometry", &["bytemuck", "dapple-math", "glam", "libm", "obvhs"], &["libc", "rayon"]),
    (
        "dapple-imaging",
        &["dapple-math", "gethostname", "glam", "libm", "tempfile", "thiserror"],
        &["ab_glyph", "exr", "half", "image", "rayon"],
    ),
    ("dapple-materials", &["dapple-math", "dapple-sampling", "glam"], &[]),
    ("dapple-lights", &["dapple-math", "dapple-sampling", "glam", "libm"], &[]),
    ("dapple-camera", &["dapple-math", "dapple-sampling", "glam", "libm"], &[]),
    (
        "dapple-scene",
        &[
            "bevy_mikktspace",
            "dapple-camera",
            "dapple-geometry",
            "dapple-imaging",
            "dapple-lights",
            "dapple-materials",
            "dapple-math",
            "dapple-sampling",
            "glam",
            "libm",
            "serde",
            "thiserror",
        ],
        &["base64", "gltf", "percent-encoding", "serde_json"],
    ),
    (
        "dapple-integrator",
        &[
            "dapple-camera",
            "dapple-geometry",
            "dapple-imaging",
            "dapple-lights",
            "dapple-materials",
            "dapple-math",
            "dapple-sampling",
            "dapple-scene",
            "glam",
            "libm",
            "thiserror",
        ],
        &["rayon"],
    ),
    (
        "dapple-analysis",
        &[
            "base64",
            "dapple-imaging",
            "dapple-integrator",
            "glam",
            "libm",
            "maud",
            "serde",
            "statrs",
            "thiserror",
        ],
        &[],
    ),
    ("dapple-verify", &["dapple-analysis", "dapple-integrator", "glam", "libm", "serde"], &[]),
    (
        "dapple",
        &[
            "clap",
            "console",
            "dapple-integrator",
            "glam",
            "indicatif",
            "postcard",
            "rustix",
            "safetensors",
            "same-file",
            "serde",
            "serde_json",
            "sha2",
            "signal-hook",
            "strsim",
            "thiserror",
            "toml",
            "tracing",
            "tracing-subscriber",
        ],
        &["clap_complete", "clap_mangen", "dapple-analysis", "dapple-verify", "maud"],
    ),
];

/// Target for which the lists hold.
const TARGET: &str = "x86_64-unknown-linux-gnu";

/// Dependencies of each feature of the program, which are absent without it.
const FEATURES: [(&str, &[&str]); 6] = [
    ("gltf", &["gltf", "gltf-json", "percent-encoding"]),
    ("exr", &["exr"]),
    ("png", &["image", "png", "zune-jpeg", "image-webp"]),
    ("parallel", &["rayon", "rayon-core"]),
    ("report", &["ab_glyph", "base64", "dapple-analysis", "dapple-verify", "maud"]),
    ("manual", &["clap_complete", "clap_mangen", "roff"]),
];

#[test]
fn features_bring_their_crates() {
    let without = tree("dapple", &["--no-default-features"]);
    for (feature, crates) in FEATURES {
        let with = tree("dapple", &["--no-default-features", "--features", feature]);
        for name in crates.iter().map(|name| name.to_string()) {
            assert!(with.contains(&name) && !without.contains(&name), "{feature}: {name}");
        }
    }
}

/// All dependencies of the smallest crate.
#[test]
fn sampling_brings_three_crates() {
    let mut all = tree("dapple-sampling", &[]);
    all.retain(|name| name != "dapple-sampling");
    assert_eq!(all, ["dapple-math", "glam", "libm"]);
}

fn direct(package: &str, default: bool) -> Vec<String> {
    let features: &[&str] = if default { &[] } else { &["--no-default-features"] };
    let mut names = tree(package, &[&["--depth", "1"], features].concat());
    names.retain(|name| name != package);
    names
}

/// Returns the names of the crates in the dependency tree, sorted, each once.
fn tree(package: &str, more: &[&str]) -> Vec<String> {
    let output = Command::new(env!("CARGO"))
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")))
        .args([
            "tree",
            "--offline",
            "--locked",
            "-e",
            "normal",
            "--prefix",
            "none",
            "-p",
            package,
            "--target",
            TARGET,
        ])
        .args(more)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let mut names: Vec<String> = text.lines().filter_map(|l| l.split(' ').next()).map(String::from).collect();
    names.sort();
    names.dedup();
    names
}

#[test]
fn direct_dependencies_are_pinned() {
    for (package, bare, added) in PINNED {
        let mut all: Vec<&str> = bare.iter().chain(added).copied().collect();
        assert_eq!(direct(package, false), bare, "{package} without default features");
        all.sort_unstable();
        assert_eq!(direct(package, true), all, "{package}");
    }
}
