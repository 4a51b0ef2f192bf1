//! `error_estimate`, `error_bound`, `--log` and `--error-limit` from outside.

mod dapple;

use dapple::{run, well};
use serde_json::Value;
use std::fs;
use std::path::Path;

fn render(folder: &Path, more: &[&str]) -> Value {
    let base = ["render", "builtin:furnace", "--size", "24x24", "-o", "a.exr", "--json"];
    well(folder, &[&base[..], more].concat()).json()
}

/// Relative RMSE against two halves.
fn truth(folder: &Path) -> f64 {
    let diff = ["diff", "a.exr", "r1.exr", "--reference-half", "r2.exr", "--json"];
    well(folder, &diff).json()["relative_rmse"].as_f64().unwrap()
}

/// The error that is stated is the error that there is, whatever the points. On this scene no pixel is much worse than
/// others, so one render is enough to tell.
#[test]
fn stated_errors_are_true() {
    let folder = tempfile::tempdir().unwrap();
    for (name, seed) in [("r1.exr", "101"), ("r2.exr", "102")] {
        let base =
            ["render", "builtin:furnace", "--size", "24x24", "--spp", "256", "--seed", seed, "-o", name];
        well(folder.path(), &base);
    }
    for arguments in [
        &["--pattern", "random"][..],
        &["--pattern", "sobol"],
        &["--pattern", "stratified"],
        &["--pattern", "sobol", "--spp", "5"],
        &["--pattern", "random", "--spp", "2"],
        &["--method", "distribution", "--max-bounces", "16", "--combine", "paired"],
    ] {
        let json = render(folder.path(), arguments);
        let ratio = |key: &str| json[key].as_f64().unwrap() / truth(folder.path());
        let (stated, bound) = (ratio("error_estimate"), ratio("error_bound"));
        assert!((0.8..1.25).contains(&stated), "{arguments:?}: {stated}");
        assert!((1.0..1.6).contains(&bound) && bound > stated, "{arguments:?}: {bound}");
    }
    let grid = render(folder.path(), &["--pattern", "grid"]);
    assert!(grid["error_estimate"].is_null() && grid["error_bound"].is_null());
}

#[test]
fn a_limit_is_held() {
    let folder = tempfile::tempdir().unwrap();
    let coarse = render(folder.path(), &["--error-limit", "0.05", "--log", "coarse.jsonl"]);
    let fine =
        render(folder.path(), &["--error-limit", "0.01", "--log", "fine.jsonl", "--pattern", "random"]);
    assert_eq!(coarse["stopped"], false);
    assert!(coarse["spp"].as_u64().unwrap() >= 64 && fine["spp"].as_u64() > coarse["spp"].as_u64());
    assert!(coarse["error_bound"].as_f64().unwrap() <= 0.05 && fine["error_bound"].as_f64().unwrap() <= 0.01);
    let log = fs::read_to_string(folder.path().join("fine.jsonl")).unwrap();
    let lines: Vec<Value> = log.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let spp: Vec<u64> = lines.iter().map(|l| l["spp"].as_u64().unwrap()).collect();
    assert!(spp.len() > 6 && spp.windows(2).all(|w| w[1] == 2 * w[0]), "{spp:?}");
    let error = |line: &Value| line["error"].as_f64().unwrap();
    assert!(error(&lines[1]) > 4.0 * error(&lines[lines.len() - 1]));
    assert!(lines.iter().all(|l| l["seconds"].is_number() && l["rays"].is_number()));
    // The first limit that is reached stops.
    assert_eq!(render(folder.path(), &["--error-limit", "1e-9", "--spp", "70"])["spp"], 70);
    let timed = render(folder.path(), &["--error-limit", "1e-9", "--time-limit", "200ms"]);
    assert!(timed["render_seconds"].as_f64().unwrap() < 10.0);
}

#[test]
fn threads_and_looking_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = || fs::read(folder.path().join("a.exr")).unwrap();
    let one = render(folder.path(), &["--threads", "1", "--spp", "32"]);
    let picture = bytes();
    let two = render(folder.path(), &["--threads", "2", "--spp", "32", "--log", "x.jsonl"]);
    assert_eq!((&one["error_estimate"], &one["error_bound"]), (&two["error_estimate"], &two["error_bound"]));
    assert!(picture == bytes());
}

#[test]
fn what_has_no_meaning_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, named) in [
        (&["--error-limit", "0"][..], "--error-limit"),
        (&["--error-limit", "0.01", "--pattern", "grid"], "--error-limit"),
        (&["--error-limit", "0.01", "--pattern", "stratified", "--spp", "64"], "--error-limit"),
        (&["--confidence", "1"], "--confidence"),
        (&["--log", "missing/x.jsonl"], "missing"),
    ] {
        let found = run(folder.path(), &[&["render", "--size", "8x8", "-o", "a.exr"], arguments].concat());
        assert_eq!(found.code, 2, "{arguments:?}");
        assert!(found.err.lines().count() == 1 && found.err.contains(named), "{}", found.err);
    }
}

/// Over 200 seeds the true error is within the bound as often as is promised. The last scene has a glass ball, whose
/// caustics are found by chance alone. Takes minutes; prints the table of `docs/error.md`:
/// `cargo test --release --test error_estimate -- --ignored --nocapture`.
#[test]
#[ignore = "minutes: 800 renders"]
fn bounds_hold_as_often_as_they_promise() {
    const SEEDS: u32 = 200;
    println!("| scene | points | limit | samples | true / stated | within the bound | below the limit |");
    println!("|---|---|---|---|---|---|---|");
    let file = |name: &str| dapple::scene(name).display().to_string();
    let scenes = [
        ("builtin:furnace".to_string(), "random", "0.04"),
        ("builtin:cornell".into(), "sobol", "0.2"),
        (file("veach_mis.gltf"), "stratified", "0.06"),
        (file("cornell_spheres.gltf"), "random", "0.2"),
    ];
    for (scene, pattern, limit) in scenes {
        let folder = tempfile::tempdir().unwrap();
        let render =
            |more: &[&str]| well(folder.path(), &[&["render", &scene, "--size", "40x40"], more].concat());
        for (name, seed) in [("r1.exr", "100001"), ("r2.exr", "100002")] {
            render(&["--spp", "8192", "--seed", seed, "-o", name]);
        }
        let (mut held, mut below, mut samples, mut ratio) = (0u32, 0u32, 0.0, 0.0);
        for seed in 0..SEEDS {
            let seed = seed.to_string();
            let arguments =
                ["--pattern", pattern, "--error-limit", limit, "--seed", &seed, "-o", "a.exr", "--json"];
            let json = render(&arguments).json();
            let (truth, number) = (truth(folder.path()), |key: &str| json[key].as_f64().unwrap());
            held += u32::from(truth <= number("error_bound"));
            below += u32::from(truth <= limit.parse().unwrap());
            samples += number("spp") / f64::from(SEEDS);
            ratio += truth / number("error_estimate") / f64::from(SEEDS);
        }
        let share = |n: u32| 100.0 * f64::from(n) / f64::from(SEEDS);
        let name = scene.rsplit('/').next().unwrap_or_default();
        println!(
            "| {name} | {pattern} | {limit} | {samples:.0} | {ratio:.2} | {:.1} % | {:.1} % |",
            share(held),
            share(below)
        );
        // 95 % less four standard errors of 200 trials.
        assert!(share(held) >= 95.0 - 6.2, "{scene}: {held} of {SEEDS}");
    }
}
