//! Integration tests of `dapple converge`: its output, its continuation, and its errors.

mod dapple;

use dapple::{Run, files, run, well};
use dapple_imaging::{Image, Layers, Tone, read, write};
use glam::Vec3;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Compares two runs of the path tracer on a small image; `more` comes last.
fn converge(folder: &Path, more: &[&str]) -> Value {
    told(folder, more).json()["results"].take()
}

fn told(folder: &Path, more: &[&str]) -> Run {
    let arguments = [
        &["converge", "builtin:cornell", "-o", "out", "--size", "16x16", "--json", "--seeds", "3"][..],
        &["--run", "random: --pattern random", "--run", "jittered: --pattern stratified"],
        more,
    ]
    .concat();
    well(folder, &arguments)
}

/// All PNGs of a scene have the same exposure, metered and printed once, or the requested one.
#[test]
fn one_exposure_for_all_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let run = told(folder.path(), &["--budget", "1500ms"]);
    let said: Vec<&str> = run.err.split("(--exposure ").skip(1).collect();
    assert!(said.len() == 1 && run.err.contains("the PNGs of builtin:cornell metered"), "{}", run.err);
    let stops: f32 = said[0].split(' ').next().unwrap().parse().unwrap();
    assert!(stops != 0.0);
    let same = |out: &str, stops: f32| {
        let read = |name: &str| read::picture(&folder.path().join(out).join(name)).unwrap();
        let expected = folder.path().join("expected.png");
        let exr = read("cornell-random-picture.exr");
        write::png(&expected, &exr, Tone::Srgb, stops).unwrap();
        assert!(read("cornell-random-picture.png").pixels == read::picture(&expected).unwrap().pixels);
        let halves = [1, 2].map(|i| read(&format!("cornell-half-{i}.exr")).mean().y);
        let mean = read("cornell-reference.png").mean().y / f32::exp2(stops);
        (mean, (halves[0] + halves[1]) / 2.0)
    };
    // If nothing is brighter than the display's white, the means are equal.
    let (shown, mean) = same("out", stops);
    assert!(shown < 1.05 * mean && shown > 0.1 * mean, "{shown} {mean}");
    let base = ["converge", "builtin:cornell", "-o", "dark", "--size", "16x16", "--seeds", "1"];
    let more = ["--run", "random: --pattern random", "--budget", "1s", "--exposure", "-8"];
    assert!(!well(folder.path(), &[&base[..], &more].concat()).err.contains("metered"));
    let (shown, mean) = same("dark", -8.0);
    assert!((shown / mean - 1.0).abs() < 0.1, "{shown} {mean}");
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
        "cornell-error-cpu-seconds.svg",
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
        assert!(seconds.len() == samples.len() && seconds.iter().all(|s| *s > 0.0), "{seconds:?}");
        assert!(mse.first() > mse.last(), "{mse:?}");
        assert!(run["slope"].as_f64().unwrap() < -0.5);
        assert!(run["efficiency"].as_f64().unwrap() > 0.0);
        assert!(run["seconds_to"].get("0.01").is_some());
        assert!(numbers(&run["cpu_seconds"]).iter().all(|s| *s > 0.0), "{run}");
        let equal = run["equal_time"].as_array().unwrap();
        assert!(equal.windows(2).all(|w| w[0]["seconds"].as_f64() > w[1]["seconds"].as_f64()));
        assert!(equal.windows(2).all(|w| w[0]["relative_rmse"].as_f64() < w[1]["relative_rmse"].as_f64()));
        assert!(equal.iter().all(|e| e["efficiency_ratio"].is_null() == (run["name"] == "random")), "{run}");
        // A busy machine may omit seeds, which is then reported.
        let seeds = run["seeds"].as_array().unwrap().len();
        let left_out = results["left_out"].to_string();
        assert_eq!(run["slope_ci"].is_array(), seeds > 1);
        assert_eq!(seeds < 3, left_out.contains(run["name"].as_str().unwrap()), "{seeds}: {left_out}");
    }
    let reference = &results["references"][0];
    assert!(reference["samples"].as_u64().unwrap() > 16 && reference["mse"].as_f64().unwrap() > 0.0);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("data:image/png;base64,") && page.contains("<svg") && !page.contains("src=\"http"));
    assert!(page.contains("After equal seconds") && page.contains("(I − R)² / (R² + 0.01)"));
    assert_eq!(page.matches(">reference</button>").count(), 1);
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

/// A uniform grey Radiance image, run-length encoded: 2 MB for 16 million pixels.
fn grey(side: usize) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {side} +X {side}\n").into_bytes();
    for _ in 0..side {
        bytes.extend([2, 2, (side >> 8) as u8, side as u8]);
        for _ in 0..4 {
            (0..side / 64).for_each(|_| bytes.extend([128 + 64, 128]));
        }
    }
    bytes
}

/// Images of other renderers are read within the memory limit.
#[test]
fn pictures_of_others_obey_the_memory_limit() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("big.hdr"), grey(4096)).unwrap();
    let command = "other=cp big.hdr {out}; true {spp}";
    let base =
        ["converge", "builtin:cornell", "-o", "out", "--size", "16x16", "--run", "a:", "--budget", "1s"];
    for limit in [&["--memory-limit", "100M"][..], &["--settings", "mine.toml"]] {
        fs::write(folder.path().join("mine.toml"), "memory-limit = '100M'").unwrap();
        let found = run(folder.path(), &[&base[..], limit, &["--external", command]].concat());
        assert_eq!(found.code, 2, "{}", found.err);
        for word in ["other", "4096×4096", "--memory-limit allows 104.9 MB"] {
            assert!(found.err.contains(word), "'{word}' is not in: {}", found.err);
        }
    }
}

/// The same renderer as an external command has the same errors, and a reference of its own.
#[test]
fn another_renderer() {
    let folder = tempfile::tempdir().unwrap();
    let own = env!("CARGO_BIN_EXE_dapple");
    let command = format!(
        "other='{own}' render {{scene}} --size 16x16 --pattern random --spp {{spp}} --seed {{seed}} -o {{out}} --quiet"
    );
    // A busy machine may need another call.
    let (results, other) = (0..8)
        .find_map(|_| {
            let results = converge(folder.path(), &["--budget", "6s", "--external", &command]);
            named(&results, "other").map(|other| (results, other))
        })
        .unwrap();
    assert_eq!(other["method"], "external");
    // On a busy machine, seconds may be lost in the spread of the start-up; then they are 0.
    let (errors, seconds) = (numbers(&other["mse"]), numbers(&other["seconds"]));
    assert!(!errors.is_empty() && errors.len() == seconds.len() && seconds.iter().all(|s| *s >= 0.0));
    let key = &other["reference"];
    let reference = results["references"].as_array().unwrap().iter().find(|r| r["key"] == *key).unwrap();
    assert!(reference["kind"].as_str().unwrap().contains("by other"));
    let failing = ["--budget", "1s", "--external", "broken=echo no such luck >&2; false {spp} {out}"];
    let base = ["converge", "builtin:cornell", "-o", "out2", "--size", "16x16", "--run", "a:"];
    let found = run(folder.path(), &[&base[..], &failing].concat());
    assert_eq!(found.code, 2);
    assert!(found.err.contains("broken") && found.err.contains("no such luck"), "{}", found.err);
}

/// Images of another renderer with the value `level` everywhere, and noise that falls with the samples: for the seeds 1
/// and 2 and for those of its reference, at powers of two.
fn pictures(folder: &Path, level: f32) {
    fs::create_dir_all(folder.join("pictures")).unwrap();
    for seed in [1u64, 2, 11, 12] {
        let mut rng = dapple_testkit::Rng::new(seed);
        for k in 0..=20 {
            let noise = 0.5 * level / ((1u32 << k) as f32).sqrt();
            let pixel = |rng: &mut dapple_testkit::Rng| Vec3::splat(level + noise * rng.normal() as f32);
            let pixels = (0..256).map(|_| pixel(&mut rng)).collect();
            let layers = Layers::from(&Image { width: 16, height: 16, pixels });
            let path = folder.join(format!("pictures/{seed}-{}.exr", 1u32 << k));
            write::exr(&path, &layers, write::Depth::Float).unwrap();
        }
    }
}

/// A command that executes `first` and then copies one of the images. The furnace is 2 everywhere.
fn peer(first: &str) -> String {
    let seed = "s={seed}; if [ $s -gt 1000000 ]; then s=$((s-1000000+10)); fi";
    format!("peer={first}; {seed}; cp pictures/$s-{{spp}}.exr '{{out}}'")
}

/// Returns the run of the other renderer, all results, and the page. If the machine is too busy for its time to
/// suffice, another call continues.
fn with_peer(folder: &Path, out: &str, command: &str, more: &[&str]) -> (Value, Value, String) {
    let base = ["converge", "builtin:furnace", "-o", out, "--size", "16x16", "--json", "--seeds", "2"];
    let runs = ["--run", "random: --pattern random", "--external", command];
    for _ in 0..8 {
        let found = well(folder, &[&base[..], &runs, more].concat());
        let results = found.json()["results"].take();
        if let Some(peer) = named(&results, "peer") {
            return (peer, results, fs::read_to_string(folder.join(out).join("report.html")).unwrap());
        }
        assert!(results["left_out"].to_string().contains("peer"), "{results}");
    }
    panic!("no time for another renderer");
}

fn named(results: &Value, name: &str) -> Option<Value> {
    results["runs"].as_array().unwrap().iter().find(|r| r["name"] == name).cloned()
}

/// The time of a command before it renders is measured and subtracted, and the page says so: this command sleeps and
/// counts, and then takes 0.02 s per sample.
#[cfg(target_os = "linux")]
#[test]
fn the_start_up_of_another_renderer() {
    let folder = tempfile::tempdir().unwrap();
    pictures(folder.path(), 2.0);
    let start = "sleep 0.2; i=0; while [ $i -lt 40000 ]; do i=$((i+1)); done";
    let render = "t=$((20*{spp})); sleep $((t/1000)).$(printf %03d $((t%1000)))";
    let command = peer(&format!("{start}; {render}"));
    let shared = ["--budget", "12s", "--shared-reference"];
    // A busy machine may have no time for the measurement, which is then reported.
    let measured = (0..4).find_map(|i| {
        let (peer, _, page) = with_peer(folder.path(), &format!("out{i}"), &command, &shared);
        let known = peer["startup_seconds"].is_number();
        assert!(known || page.contains("start-up included"));
        known.then_some((peer, page))
    });
    let (peer, page) = measured.unwrap();
    let startup = peer["startup_seconds"].as_f64().unwrap();
    let cpu = peer["startup_cpu_seconds"].as_f64().unwrap();
    assert!(startup >= 0.0 && cpu >= 0.0, "{startup} {cpu}");
    // The command sleeps 0.2 s and 0.02 s per sample, so that start-up and remainder are together at least that long. A
    // remainder that is lost in the spread of the start-up is 0.
    let points = peer["seeds"][0]["points"].as_array().unwrap();
    assert!(!points.is_empty());
    for point in points {
        let (samples, seconds) = (point["samples"].as_f64().unwrap(), point["seconds"].as_f64().unwrap());
        assert!(seconds == 0.0 || seconds + startup >= 0.2 + 0.02 * samples, "{point} {startup}");
    }
    assert!(peer["timing"].as_str().unwrap().contains(&format!("start-up of {startup:.3} s")), "{peer}");
    assert!(peer["timing"].as_str().unwrap().contains("minus its start-up of"), "{peer}");
    assert!(page.contains("minus its start-up of"));
}

/// A command may report its rendering time itself.
#[test]
fn a_renderer_that_tells_its_time() {
    let folder = tempfile::tempdir().unwrap();
    pictures(folder.path(), 2.0);
    let command = peer("echo 0.125 0.25 > '{time}'");
    let (run_of_peer, _, page) = with_peer(folder.path(), "out", &command, &["--budget", "5s"]);
    let points = run_of_peer["seeds"][0]["points"].as_array().unwrap();
    assert!(!points.is_empty() && run_of_peer["startup_seconds"].is_null(), "{run_of_peer}");
    for point in points {
        assert_eq!((&point["seconds"], &point["cpu_seconds"]), (&0.125.into(), &0.25.into()));
    }
    assert!(page.contains("the command itself wrote"));
    let base =
        ["converge", "builtin:furnace", "-o", "bad", "--size", "16x16", "--run", "a:", "--budget", "1s"];
    for (told, said) in [("echo fast > '{time}'", "one or two numbers"), ("true '{time}'", "no {time} file")]
    {
        let found = run(folder.path(), &[&base[..], &["--external", &peer(told)]].concat());
        assert_eq!(found.code, 2, "{}", found.out);
        assert!(found.err.contains("peer") && found.err.contains(said), "{}", found.err);
    }
}

/// Every renderer has a reference of its own with a description; if the references differ, a warning states by how
/// much, and only one button is called reference.
#[test]
fn references_that_differ() {
    let folder = tempfile::tempdir().unwrap();
    pictures(folder.path(), 2.0);
    let (_, results, page) = with_peer(folder.path(), "same", &peer("true"), &["--budget", "4s"]);
    assert_eq!(results["differences"][0]["beyond_noise"], false, "{}", results["differences"]);
    assert!(!page.contains("Warning"));
    assert_eq!(page.matches(">reference</button>").count(), 1);
    assert_eq!(page.matches(">reference of peer</button>").count(), 1);
    assert!(page.contains("two halves by peer") && page.contains("halves by dapple's path tracer"));
    // A quarter darker.
    pictures(folder.path(), 1.5);
    let (_, results, page) = with_peer(folder.path(), "other", &peer("true"), &["--budget", "4s"]);
    let difference = &results["differences"][0];
    assert_eq!(difference["beyond_noise"], true, "{difference}");
    assert!((difference["relative_rmse"].as_f64().unwrap() - 0.25).abs() < 0.05, "{difference}");
    assert!(page.contains("Warning") && page.contains("differ by 25 %"), "{page}");
    // Compared with one shared reference, that is an error that does not fall.
    let shared = ["--budget", "4s", "--shared-reference"];
    let (run_of_peer, results, page) = with_peer(folder.path(), "shared", &peer("true"), &shared);
    assert_eq!(results["references"].as_array().unwrap().len(), 1);
    assert_eq!(run_of_peer["reference"], results["references"][0]["key"]);
    assert!(results["differences"].as_array().unwrap().is_empty() && !page.contains("Warning"));
    assert!(numbers(&run_of_peer["relative_rmse"]).iter().all(|error| *error > 0.2), "{run_of_peer}");
}

/// A command without seeds has a single image as its reference, whose noise is unknown, and a single seed has no
/// interval.
#[test]
fn a_renderer_without_seeds() {
    let folder = tempfile::tempdir().unwrap();
    pictures(folder.path(), 2.0);
    let command = "peer=echo 0.5 > {time}; cp pictures/1-{spp}.exr '{out}'";
    let (run_of_peer, results, page) = with_peer(folder.path(), "out", command, &["--budget", "5s"]);
    assert_eq!(run_of_peer["seeds"].as_array().unwrap().len(), 1);
    assert!(page.contains("one image by peer") && page.contains("may share samples with it"));
    assert!(results["differences"][0]["beyond_noise"].is_null());
    assert!(run_of_peer["efficiency_ci"].is_null() && page.contains("interval not known"));
}

/// `--seed` sets the first seed of the runs: other seeds give other images, with another reference.
#[test]
fn seeds_begin_where_they_are_told_to() {
    let folder = tempfile::tempdir().unwrap();
    let of = |out: &str, more: &[&str]| {
        let base = ["converge", "builtin:cornell", "-o", out, "--size", "16x16", "--json", "--seeds", "2"];
        let more = [&["--budget", "2s", "--run", "a: --pattern random"], more].concat();
        well(folder.path(), &[&base[..], &more].concat()).json()["results"].take()
    };
    let first = |results: &Value| results["runs"][0]["seeds"][0]["seed"].as_u64();
    let error = |results: &Value| results["runs"][0]["seeds"][0]["points"][0]["mse"].as_f64();
    let (usual, one, other) = (of("a", &[]), of("b", &["--seed", "1"]), of("c", &["--seed", "500"]));
    assert_eq!([first(&usual), first(&one), first(&other)], [Some(1), Some(1), Some(500)]);
    assert!(error(&usual) != error(&other));
    assert!(usual["references"][0]["mean"] != other["references"][0]["mean"]);
    // In the same folder they are added.
    let more = of("a", &["--seed", "500"]);
    let seeds = more["runs"][0]["seeds"].as_array().unwrap();
    assert!(seeds.iter().any(|s| s["seed"] == 1) && seeds.iter().any(|s| s["seed"] == 500));
}

#[test]
fn bad_input() {
    let folder = tempfile::tempdir().unwrap();
    well(folder.path(), &["render", "builtin:cornell", "--size", "8x8", "--spp", "1", "-o", "small.exr"]);
    let crop = ["--size", "16x16", "--crop", "0,0,8,8", "--spp", "1", "-o", "crop.exr"];
    well(folder.path(), &[&["render", "builtin:cornell"], &crop[..]].concat());
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
        (&["-o", "out", "--run", "mine: --exposure 4"], &["mine", "exposure"]),
        (&["-o", "out", "--run", "--method path"], &["--run"]),
        (&["-o", "out", "--run", "a:", "--run", "a:"], &["a", "used twice"]),
        (&["-o", "out", "--vary", "mood"], &["--vary"]),
        (&["-o", "out", "--external", "x=y"], &["--external", "{spp}"]),
        (&["-o", "out", "--spp", "4"], &["--spp"]),
        (&["-o", "out", "--seeds", "0"], &["--seeds"]),
        (&["-o", "out", "--seed", "3000000000"], &["--seed", "2000000000"]),
        (&["-o", "out", "--run", "a b:", "--run", "a-b:"], &["a-b", "used twice"]),
        (&["-o", "out", "--run", "reference:"], &["reference", "another name"]),
        (&["-o", "out", "--run", "a:", "--external", "a={spp} {out}"], &["--external a", "used twice"]),
        (&["cornell.gltf", "-o", "out"], &["cornell.gltf", "same names"]),
        (&["-o", "out", "--reference", "crop.exr"], &["crop.exr", "0,0 to 8,8 of 16x16"]),
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
