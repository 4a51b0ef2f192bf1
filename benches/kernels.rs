//! Benchmark of specialised kernels: every scene of `scenes/` by the chosen plan and by the general one; time, memory,
//! and, with `-- --instructions`, instructions as counted by valgrind. Nothing is asserted; `-- --smoke` takes one
//! scene.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

const DAPPLE: &str = env!("CARGO_BIN_EXE_dapple");

fn main() {
    let asked = |flag: &str| std::env::args().any(|a| a == flag);
    let mut scenes = scenes();
    if asked("--smoke") {
        scenes.truncate(1);
    }
    println!("| scene | time chosen / general | 95 % interval | bytes | ratio | instructions |");
    println!("|---|---|---|---|---|---|");
    for scene in scenes {
        let Some(measured) = measured(&scene) else { continue };
        let number = |key: &str| measured[key].as_f64().unwrap_or(f64::NAN);
        let bytes = (number("bytes"), number("general_bytes"));
        let instructions = if asked("--instructions") { instructions(&scene) } else { "-".into() };
        println!(
            "| {} | {:.3} | {:.3} … {:.3} | {:.0} / {:.0} | {:.3} | {instructions} |",
            scene.file_stem().unwrap_or_default().to_string_lossy(),
            number("time_ratio"),
            number("time_ratio_low"),
            number("time_ratio_high"),
            bytes.0,
            bytes.1,
            bytes.0 / bytes.1,
        );
    }
}

fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
    let mut all: Vec<PathBuf> = entries.filter(|p| p.extension().is_some_and(|e| e == "gltf")).collect();
    all.sort();
    all
}

/// Returns the ratios measured by `dapple plan --measure`.
fn measured(scene: &Path) -> Option<Value> {
    let out = Command::new(DAPPLE)
        .arg("plan")
        .arg(scene)
        .args(["--measure", "--json", "--size", "128x96", "--threads", "1"])
        .output()
        .ok()?;
    let text = String::from_utf8(out.stdout).ok()?;
    let json: Value = serde_json::from_str(text.lines().last()?).ok()?;
    Some(json["measured"].clone())
}

/// Ratio of instructions, chosen over general, including loading; `-` without valgrind.
fn instructions(scene: &Path) -> String {
    match (count(scene, "smallest"), count(scene, "general")) {
        (Some(chosen), Some(general)) => format!("{:.3}", chosen / general),
        _ => "-".into(),
    }
}

fn count(scene: &Path, plan: &str) -> Option<f64> {
    let folder = tempfile::tempdir().ok()?;
    let out = Command::new("valgrind")
        .current_dir(folder.path())
        .args(["--tool=callgrind", "--callgrind-out-file=counts", DAPPLE, "render"])
        .arg(scene)
        .args(["--size", "64x48", "--spp", "8", "--threads", "1", "--quiet", "-o", "a.hdr", "--plan", plan])
        .output()
        .ok()?;
    let text = String::from_utf8_lossy(&out.stderr).into_owned();
    let line = text.lines().find(|l| l.contains("Collected"))?;
    line.rsplit(' ').next()?.parse().ok()
}
