//! `--adaptive`: the expected image is unchanged, only the error differs.

mod dapple;
mod fireflies;

use dapple::{run, well};
use dapple_imaging::read;
use serde_json::Value;
use std::fs;
use std::path::Path;

fn render(folder: &Path, more: &[&str]) -> Value {
    let base = ["render", "builtin:cornell", "--size", "24x24", "-o", "a.exr", "--json", "--adaptive"];
    well(folder, &[&base[..], more].concat()).json()
}

#[test]
fn samples_are_where_they_are_said_to_be() {
    let folder = tempfile::tempdir().unwrap();
    let json = render(folder.path(), &["--spp", "64", "--aov", "samples"]);
    let layers = read::layers(&folder.path().join("a.exr")).unwrap();
    let counts = &layers.layers.iter().find(|l| l.name == "samples").unwrap().channels[0].1;
    let total: f64 = counts.iter().map(|c| f64::from(*c)).sum();
    assert_eq!(Some(total), json["samples"].as_f64());
    assert!((total / (24.0 * 24.0 * 64.0) - 1.0).abs() < 0.02, "{total}");
    let (least, most) = counts.iter().fold((f32::MAX, 0.0f32), |(a, b), c| (a.min(*c), b.max(*c)));
    // An even quarter of the 48 further samples, randomly rounded.
    assert!((27.0..50.0).contains(&least) && most > 100.0, "{least} {most}");
}

/// The number of threads, snapshots, and the division into passes change no bit; up to the pilot nothing differs.
#[test]
fn it_is_as_repeatable_as_ever() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = || fs::read(folder.path().join("a.exr")).unwrap();
    let one = render(folder.path(), &["--spp", "40", "--threads", "1"]);
    let picture = bytes();
    let two = render(folder.path(), &["--spp", "40", "--threads", "2", "--log", "x.jsonl"]);
    assert!(picture == bytes());
    assert_eq!((&one["error_estimate"], &one["error_bound"]), (&two["error_estimate"], &two["error_bound"]));
    let pixels = || read::picture(&folder.path().join("a.exr")).unwrap().pixels;
    render(folder.path(), &["--spp", "16"]);
    let pilot = pixels();
    well(folder.path(), &["render", "builtin:cornell", "--size", "24x24", "-o", "a.exr", "--spp", "16"]);
    assert!(pilot == pixels());
}

/// The mean over 48 renders with few further samples equals a converged image: pixels that decided on their own sample
/// count would be too dark.
#[test]
fn no_bias() {
    let folder = tempfile::tempdir().unwrap();
    let mean = |name: &str| f64::from(read::picture(&folder.path().join(name)).unwrap().mean().element_sum());
    let truth: Vec<f64> = ["random", "sobol"]
        .iter()
        .map(|pattern| {
            let base = ["render", "builtin:cornell", "--size", "24x24", "-o", "r.exr", "--spp", "2048"];
            well(folder.path(), &[&base[..], &["--pattern", pattern]].concat());
            mean("r.exr")
        })
        .collect();
    let means: Vec<f64> = (0..48)
        .map(|seed| {
            let seed = seed.to_string();
            render(folder.path(), &["--spp", "32", "--pattern", "random", "--seed", &seed]);
            mean("a.exr")
        })
        .collect();
    let found = dapple_analysis::statistics::mean(&means, 0.9999).unwrap();
    let room = 2.0 * (truth[0] - truth[1]).abs();
    assert!(found.low - room <= truth[1] && truth[1] <= found.high + room, "{found:?} {truth:?}");
    assert!((found.high - found.low) / found.value < 0.03, "{found:?}");
}

#[test]
fn what_does_not_go_together() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, named) in [
        (&["--crop", "0,0,8,8"][..], "--crop"),
        (&["--pattern", "stratified"], "--pattern"),
        (&["--pattern", "grid"], "--pattern"),
        (&["--method", "distribution"], "--method"),
    ] {
        let base = ["render", "builtin:cornell", "--size", "16x16", "-o", "a.exr", "--adaptive"];
        let found = run(folder.path(), &[&base[..], arguments].concat());
        assert_eq!(found.code, 2, "{arguments:?}");
        let line = &found.err;
        assert!(line.lines().count() == 1 && line.contains("--adaptive") && line.contains(named), "{line}");
    }
}

/// Measures the bias that `--error-limit` causes in a pixel dominated by few samples, by stopping when they look good
/// enough; uniform and adaptive. Printed for `docs/error.md`; if unseen light were ignored, the bias would be tens of
/// percent.
#[test]
#[ignore = "long: 2400 renders, minutes"]
fn stopping_by_the_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = fireflies::written(folder.path(), "star", &fireflies::star()).display().to_string();
    let exact = 1.0 + 499.0 / 64.0;
    for (limit, more) in [("0.5", &[][..]), ("0.2", &[]), ("0.2", &["--adaptive"])] {
        let (mut means, mut samples) = (Vec::new(), 0.0);
        for seed in 0..800 {
            let seed = seed.to_string();
            let base =
                ["render", &file, "--size", "16x12", "--max-bounces", "0", "--pattern", "random", "--json"];
            let limit = ["--error-limit", limit, "--env-color", "0,0,0", "--seed", &seed, "-o", "a.exr"];
            let found = run(folder.path(), &[&base[..], &limit, more].concat());
            // If the cap on samples comes first, the image is kept and counts like any other.
            assert!([0, 3].contains(&found.code), "{limit:?}: {}", found.err);
            let json = found.json();
            samples += json["spp"].as_f64().unwrap() / 800.0;
            let picture = read::picture(&folder.path().join("a.exr")).unwrap();
            means.push(f64::from(picture.pixels[4 * 16 + 9].y) / exact);
        }
        let found = dapple_analysis::statistics::mean(&means, 0.95).unwrap();
        let (off, room) = (100.0 * (found.value - 1.0), 50.0 * (found.high - found.low));
        println!("| {limit} {} | {samples:.0} | {off:+.1} % ± {room:.1} % |", more.join(" "));
        assert!(off.abs() <= 10.0 + 2.0 * room, "{limit}: {off} ± {room}");
    }
}
