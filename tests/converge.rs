//! `dapple converge` from outside: what it writes, that it goes on where it was, and what it refuses.

mod dapple;

use dapple::{files, run, well};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Two runs of the path tracer on a small picture; `more` comes last.
fn converge(folder: &Path, more: &[&str]) -> Value {
    let arguments = [
        &["converge", "builtin:cornell", "-o", "out", "--size", "16x16", "--json", "--seeds", "3"][..],
        &["--run", "random: --pattern random", "--run", "jittered: --pattern stratified"],
        more,
    ]
    .concat();
    well(folder, &arguments).json()["results"].take()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn everything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let results = converge(folder.path(), &["--budget", "4s"]);
    let out = folder.path().join("out");
    for name in [
        "results.json",
        "results.csv",
        "report.html",
        "cornell-error-seconds.svg",
        "cornell-error-seconds.png",
        "cornell-error-samples.svg",
        "cornell-half-1.exr",
        "cornell-half-2.exr",
        "cornell-reference.png",
        "cornell-random-picture.png",
        "cornell-random-errors.png",
        "cornell-jittered-picture.exr",
    ] {
        assert!(out.join(name).is_file(), "{name} is missing: {:?}", files(&out));
    }
    let read: Value = serde_json::from_slice(&fs::read(out.join("results.json")).unwrap()).unwrap();
    assert_eq!(read["runs"].as_array().unwrap().len(), 2);
    assert_eq!(results["runs"][0]["name"], "random");
    for run in results["runs"].as_array().unwrap() {
        let [samples, seconds, mse] = ["samples", "seconds", "mse"].map(|key| numbers(&run[key]));
        assert!(samples.len() >= 3 && samples.windows(2).all(|w| w[1] == 2.0 * w[0]), "{samples:?}");
        // A busy machine may hold up one of two renders of milliseconds; not eight times as many samples.
        assert!(seconds.windows(4).all(|w| w[3] > w[0]) && seconds.first() < seconds.last(), "{seconds:?}");
        assert!(mse.first() > mse.last(), "{mse:?}");
        assert!(run["slope"].as_f64().unwrap() < -0.5 && run["slope_ci"].is_array());
        assert!(run["efficiency"].as_f64().unwrap() > 0.0);
        assert!(run["seconds_to"].get("0.01").is_some());
        // A busy machine may leave seeds out; then it is said.
        let seeds = run["seeds"].as_array().unwrap().len();
        let left_out = results["left_out"].to_string();
        assert_eq!(seeds < 3, left_out.contains(run["name"].as_str().unwrap()), "{seeds}: {left_out}");
    }
    let reference = &results["references"][0];
    assert!(reference["samples"].as_u64().unwrap() > 16 && reference["mse"].as_f64().unwrap() > 0.0);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("data:image/png;base64,") && page.contains("<svg") && !page.contains("src=\"http"));
    let csv = fs::read_to_string(out.join("results.csv")).unwrap();
    assert!(csv.starts_with("scene,run,seed,samples,seconds"), "{csv}");
}

#[test]
fn a_second_call_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let first = converge(folder.path(), &["--budget", "1500ms"]);
    let second = converge(folder.path(), &["--budget", "2s"]);
    assert_eq!(first["references"][0]["mse"], second["references"][0]["mse"]);
    for (old, new) in first["runs"].as_array().unwrap().iter().zip(second["runs"].as_array().unwrap()) {
        let seeds = |run: &Value| run["seeds"].as_array().unwrap().clone();
        let (old, new) = (seeds(old), seeds(new));
        assert!(new.len() >= old.len(), "{} then {}", old.len(), new.len());
        assert_eq!(old, new[..old.len()]);
    }
    assert!(second["spent_seconds"].as_f64() > first["spent_seconds"].as_f64());
}

#[test]
fn a_reference_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    well(folder.path(), &["render", "builtin:cornell", "--size", "16x16", "--spp", "1024", "-o", "r.exr"]);
    let results = converge(folder.path(), &["--budget", "1500ms", "--reference", "r.exr"]);
    assert_eq!(
        (&results["references"][0]["kind"], &results["references"][0]["mse"]),
        (&"r.exr".into(), &0.0.into())
    );
    assert!(results["runs"][0]["slope"].as_f64().unwrap() < -0.5);
}

/// The same renderer from outside has the same errors, and a reference of its own.
#[test]
fn another_renderer() {
    let folder = tempfile::tempdir().unwrap();
    let own = env!("CARGO_BIN_EXE_dapple");
    let command = format!(
        "other='{own}' render {{scene}} --size 16x16 --pattern random --spp {{spp}} --seed {{seed}} -o {{out}} --quiet"
    );
    let results = converge(folder.path(), &["--budget", "6s", "--external", &command]);
    let other = results["runs"].as_array().unwrap().iter().find(|r| r["name"] == "other").unwrap();
    assert_eq!(other["method"], "external");
    assert!(!numbers(&other["mse"]).is_empty() && numbers(&other["seconds"])[0] > 0.0);
    let key = &other["reference"];
    let reference = results["references"].as_array().unwrap().iter().find(|r| r["key"] == *key).unwrap();
    assert!(reference["kind"].as_str().unwrap().contains("by other"));
    let failing = ["--budget", "1s", "--external", "broken=echo no such luck >&2; false {spp} {out}"];
    let base = ["converge", "builtin:cornell", "-o", "out2", "--size", "16x16", "--run", "a:"];
    let found = run(folder.path(), &[&base[..], &failing].concat());
    assert_eq!(found.code, 2);
    assert!(found.err.contains("broken") && found.err.contains("no such luck"), "{}", found.err);
}

#[test]
fn bad_input() {
    let folder = tempfile::tempdir().unwrap();
    well(folder.path(), &["render", "builtin:cornell", "--size", "8x8", "--spp", "1", "-o", "small.exr"]);
    fs::write(folder.path().join("file"), "").unwrap();
    fs::create_dir(folder.path().join("other")).unwrap();
    fs::write(folder.path().join("other/results.json"), "{}").unwrap();
    let base = ["converge", "builtin:cornell", "--size", "16x16", "--budget", "1s"];
    for (arguments, named) in [
        (&["-o", "out", "--reference", "small.exr"][..], &["small.exr", "8x8", "16x16"][..]),
        (&["-o", "out", "--reference", "missing.exr"], &["missing.exr"]),
        (&["-o", "out", "--budget", "0s"], &["--budget"]),
        (&["-o", "out", "--run", "mine: --method guesswork"], &["mine", "guesswork"]),
        (&["-o", "out", "--run", "mine: --size 4x4"], &["mine", "size"]),
        (&["-o", "out", "--run", "--method path"], &["--run"]),
        (&["-o", "out", "--run", "a:", "--run", "a:"], &["a", "two"]),
        (&["-o", "out", "--vary", "mood"], &["--vary"]),
        (&["-o", "out", "--external", "x=y"], &["--external", "{spp}"]),
        (&["-o", "out", "--spp", "4"], &["--spp"]),
        (&["-o", "out", "--seeds", "0"], &["--seeds"]),
        (&["-o", "file/out"], &["file/out"]),
        (&["-o", "file"], &["file"]),
        (&["-o", "other"], &["results.json"]),
        (&[], &["DIR"]),
    ] {
        let found = run(folder.path(), &[&base[..], arguments].concat());
        assert_eq!(found.code, 2, "{arguments:?}: {} {}", found.out, found.err);
        assert_eq!(found.err.lines().count(), 1, "{}", found.err);
        assert!(named.iter().all(|n| found.err.contains(n)), "{arguments:?}: {}", found.err);
    }
}
