//! Integration tests of `dapple budget`: its predictions hold.

mod dapple;

use dapple::{run, scene, well};
use serde_json::Value;
use std::path::Path;

fn truth(folder: &Path) -> f64 {
    let diff = ["diff", "a.exr", "r1.exr", "--reference-half", "r2.exr", "--json"];
    well(folder, &diff).json()["relative_rmse"].as_f64().unwrap()
}

fn pair(value: &Value) -> [f64; 2] {
    [0, 1].map(|i| value[i].as_f64().unwrap())
}

/// With the samples of the interval's lower end the error is above the limit, with those of the upper end below.
/// `seeds` images are enough to tell the errors at both ends from the limit.
fn predictions_hold(scene: &str, limit: &str, pattern: &str, seeds: u32) {
    let folder = tempfile::tempdir().unwrap();
    let base = ["--size", "40x40", "--pattern", pattern];
    for (name, seed) in [("r1.exr", "901"), ("r2.exr", "902")] {
        let best = ["render", scene, "--size", "40x40", "--spp", "512", "--seed", seed, "-o", name];
        well(folder.path(), &best);
    }
    let budget =
        well(folder.path(), &[&["budget", scene, "--error-limit", limit, "--json"], &base[..]].concat());
    let budget = budget.json();
    let shares: Vec<f64> =
        budget["effects"].as_array().unwrap().iter().map(|e| e["share"].as_f64().unwrap()).collect();
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 0.05, "{budget}");
    let limit: f64 = limit.parse().unwrap();
    for prediction in budget["predictions"].as_array().unwrap() {
        let options: Vec<&str> = prediction["options"].as_str().unwrap().split_whitespace().collect();
        let at = |samples: f64| {
            let count = format!("{:.0}", samples.max(1.0));
            let mut options: Vec<String> = options.iter().map(|o| o.to_string()).collect();
            let varied = options.iter().position(|o| o == "--spp" || o == "--pixel").unwrap();
            options[varied + 1] = if options[varied] == "--spp" { count } else { count + ":random" };
            // The expected error is predicted: that of several seeds together.
            let squares = (5..5 + seeds).map(|seed| {
                let seed = seed.to_string();
                let mut arguments =
                    vec!["render", scene, "--size", "40x40", "--seed", &seed, "-o", "a.exr", "--yes"];
                arguments.extend(options.iter().map(String::as_str));
                well(folder.path(), &arguments);
                truth(folder.path()).powi(2)
            });
            (squares.sum::<f64>() / f64::from(seeds)).sqrt()
        };
        let [few, many] = pair(&prediction["samples_ci"]);
        let samples = prediction["samples"].as_f64().unwrap();
        assert!(few < samples && samples < many && many < 4.0 * few, "{prediction}");
        let (above, below) = (at(few.floor()), at(many.ceil()));
        println!("{scene} {prediction}: {above} at {few:.0}, {below} at {many:.0}");
        assert!(above >= limit && below <= limit, "{above} and {below}: {prediction}");
        let [low, high] = pair(&prediction["seconds_ci"]);
        let seconds = prediction["seconds"].as_f64().unwrap();
        assert!(0.0 < low && low < seconds && seconds < high);
    }
}

#[test]
fn counts_are_predicted() {
    let file = scene("soft_shadow.gltf").display().to_string();
    predictions_hold(&file, "0.02", "sobol", 4);
    predictions_hold("builtin:furnace", "0.05", "random", 16);
}

/// Small images have few pixels for an error estimate: the pilot takes more samples of them until the intervals are as
/// narrow as those of large images. With few blocks alone, this one spanned 3 to 1944 samples, and 1 to 1.6 million.
#[test]
fn small_pictures_are_predicted_too() {
    let folder = tempfile::tempdir().unwrap();
    let base = ["budget", "builtin:cornell", "--error-limit", "0.1", "--size", "24x16", "--json"];
    let json = well(folder.path(), &base).json();
    for p in json["predictions"].as_array().unwrap() {
        let [low, high] = pair(&p["samples_ci"]);
        assert!(high <= 4.0 * low && p["is_narrow"] == true, "{p}");
    }
}

/// If the only visible feature is the edge of a lamp, the error is attributed to the lamp; with a lens, also to the
/// lens.
#[test]
fn effects_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let shares = |file: &str, more: &[&str]| {
        let file = scene(file).display().to_string();
        let base = ["budget", &file, "--error-limit", "0.02", "--size", "64x40", "--json"];
        let json = well(folder.path(), &[&base[..], more].concat()).json();
        move |name: &str| -> Option<f64> {
            let all = json["effects"].as_array().unwrap();
            all.iter().find(|e| e["effect"] == name).map(|e| e["share"].as_f64().unwrap())
        }
    };
    let shadow = shares("soft_shadow.gltf", &["--diffuse", "0", "--pixel", "0"]);
    assert!(
        (shadow("light").unwrap() - 1.0).abs() < 1e-12 && shadow("lens").is_none(),
        "{:?}",
        shadow("light")
    );
    let edges = shares("soft_shadow.gltf", &["--diffuse", "0", "--light", "0"]);
    assert!((edges("pixel").unwrap() - 1.0).abs() < 1e-12, "{:?}", edges("pixel"));
    let lens = shares("depth_of_field.gltf", &[]);
    assert!(lens("lens").unwrap() > 0.2, "{:?}", lens("lens"));
    let moving = shares("motion_blur.gltf", &[]);
    assert!(moving("time").unwrap() > 0.1, "{:?}", moving("time"));
    let pinhole = shares("depth_of_field.gltf", &["--lens", "0"]);
    assert!(pinhole("lens").is_none_or(|share| share == 0.0));
}

#[test]
fn what_cannot_be_predicted_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, named) in [
        (&[][..], "--error-limit"),
        (&["--error-limit", "0.1", "--pattern", "grid"], "--pattern"),
        (&["--error-limit", "0"], "--error-limit"),
    ] {
        let found =
            run(folder.path(), &[&["budget", "builtin:cornell", "--size", "8x8"], arguments].concat());
        assert_eq!(found.code, 2, "{arguments:?}");
        assert!(found.err.lines().count() == 1 && found.err.contains(named), "{}", found.err);
    }
}
