//! The distribution tracer on the command line: its options, its ray forecast, contact sheets, and settings that
//! reproduce the image.

mod dapple;

use dapple::{files, run, scene, triangle, well};
use dapple_imaging::picture::MetaValue;
use dapple_imaging::read;
use std::fs;
use std::path::Path;

const CORNELL: [&str; 6] = ["render", "builtin:cornell", "--method", "distribution", "--size", "12x8"];
const FEW: [&str; 8] = ["--pixel", "2x1", "--light", "2x2:grid", "--glossy", "1", "--max-bounces", "2"];

fn pixels(path: &Path) -> Vec<[u32; 3]> {
    read::picture(path).unwrap().pixels.iter().map(|p| p.to_array().map(f32::to_bits)).collect()
}

#[test]
fn a_distribution_render_says_its_rays_and_writes() {
    let folder = tempfile::tempdir().unwrap();
    let run = well(folder.path(), &[&CORNELL[..], &FEW, &["--json"]].concat());
    assert_eq!(files(folder.path()), ["cornell.exr", "cornell.png"]);
    // 2 · (1 + 4 + 1 · (1 + 1)): camera, shadow and diffuse rays, and the same with one sample after the first hit.
    assert!(run.err.contains("at most 16 rays per pixel"), "{}", run.err);
    let json = run.json();
    assert_eq!((&json["method"], &json["spp"]), (&"distribution".into(), &2.into()));
    assert!(json["rays"].as_u64().unwrap() <= 16 * 12 * 8);
    let mean = read::picture(&folder.path().join("cornell.exr")).unwrap().mean();
    assert!(mean.min_element() > 0.01, "{mean}");
}

#[test]
fn what_a_scene_lacks_is_noted_and_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let plain = well(folder.path(), &[&CORNELL[..], &FEW, &["-o", "a.exr"]].concat());
    let more = ["--lens", "7x7", "--time", "9", "--refract", "5", "-o", "b.exr"];
    let noted = well(folder.path(), &[&CORNELL[..], &FEW, &more].concat());
    for effect in ["--lens", "--time", "--refract"] {
        let note = format!("note: {effect} is ignored: the scene has no such effect");
        assert!(noted.err.contains(&note) && !plain.err.contains(&note), "{}", noted.err);
    }
    // It neither affects the forecast nor changes the image.
    assert!(noted.err.contains("at most 16 rays per pixel"), "{}", noted.err);
    assert!(pixels(&folder.path().join("a.exr")) == pixels(&folder.path().join("b.exr")));
    let by_path = ["render", "builtin:cornell", "--size", "8x8", "--spp", "1", "--light", "3x3"];
    assert!(well(folder.path(), &by_path).err.contains("note: --light is ignored"));
}

#[test]
fn many_rays_need_a_yes() {
    let folder = tempfile::tempdir().unwrap();
    let many = ["--pixel", "200x200", "--light", "1", "--diffuse", "0", "--max-bounces", "3"];
    let many =
        [&["render", "builtin:cornell", "--method", "distribution", "--size", "2x1"], &many[..]].concat();
    // Camera and shadow ray.
    assert!(well(folder.path(), &many).err.contains("at most 80000 rays"));
    fs::remove_file(folder.path().join("cornell.exr")).unwrap();
    fs::remove_file(folder.path().join("cornell.png")).unwrap();
    let more = many.iter().map(|&a| if a == "1" { "1x2" } else { a }).collect::<Vec<_>>();
    let refused = run(folder.path(), &more);
    assert_eq!((refused.code, refused.out.as_str()), (2, ""), "{}", refused.err);
    assert!(refused.err.contains("120000 rays") && refused.err.contains("--yes"), "{}", refused.err);
    assert!(files(folder.path()).is_empty());
    well(folder.path(), &[&more[..], &["--yes"]].concat());
}

/// Returns the `settings` attribute of an EXR.
fn settings_of(path: &Path) -> String {
    let layers = read::layers(path).unwrap();
    let found = layers.metadata.into_iter().find(|(key, _)| key == "settings");
    match found.unwrap().1 {
        MetaValue::Text(text) => text,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_settings_in_an_exr_give_its_picture_again() {
    let folder = tempfile::tempdir().unwrap();
    well(folder.path(), &["render", "builtin:cornell", "--size", "6x3", "--spp", "1", "-o", "sky.exr"]);
    let lens = ["--aperture-radius", "0.05", "--focus-distance", "1.1", "--aperture-shape", "blades:5:12"];
    let off = ["--diffuse", "0", "--ambient", "0.3,0.2,0.1"];
    for (i, more) in [
        [&CORNELL[..], &FEW, &lens, &["--seed", "77", "--secondary", "2"]].concat(),
        [
            &CORNELL[..],
            &lens,
            &off,
            &["--combine", "paired", "--lens", "3:random", "--pixel", "3x1:sobol", "--filter", "tent"],
        ]
        .concat(),
        [&CORNELL[..], &off, &["--pixel", "0", "--lens", "1", "--crop", "3,2,9,7"]].concat(),
        vec!["render", "builtin:cornell", "--size", "12x8", "--spp", "3", "--light", "0", "--pixel", "0"],
        [&CORNELL[..], &["--env", "sky.exr", "--env-rotation", "70", "--env-intensity", "0.5"]].concat(),
        [&CORNELL[..], &["--env", "sky.exr", "--env-smooth", "--camera", "0"]].concat(),
        [&CORNELL[..], &["--env-color", "0.1,0.2,0.3", "--env-intensity", "2"]].concat(),
        [&CORNELL[..], &["--env", "sky.exr", "--env-nearest", "--backfaces", "culled"]].concat(),
        [&CORNELL[..], &["--env", "sky.exr", "--env-smooth=false", "--cull-backfaces=false"]].concat(),
        [&CORNELL[..], &["--look-from", "0.1,-0.25,2", "--fov", "30", "--up", "0.1,1,0"]].concat(),
        [&CORNELL[..], &["--orbit", "-200.5,30", "--look-at", "0.25,0.25,0.3"]].concat(),
        [&CORNELL[..], &["--orbit", "170,10,1.5", "--backfaces", "shown"]].concat(),
        [&CORNELL[..], &["--camera", "0", "--fov", "20", "--look-at", "0.2,0.3,0.3"]].concat(),
    ]
    .into_iter()
    .enumerate()
    {
        let (a, b, toml) = (format!("a{i}.exr"), format!("b{i}.exr"), format!("{i}.toml"));
        well(folder.path(), &[&more[..], &["-o", &a]].concat());
        let text = settings_of(&folder.path().join(&a));
        fs::write(folder.path().join(&toml), &text).unwrap();
        well(folder.path(), &["render", "builtin:cornell", "--settings", &toml, "-o", &b]);
        let [a, b] = [a, b].map(|name| folder.path().join(name));
        assert!(pixels(&a) == pixels(&b), "{text}");
        assert_eq!(text, settings_of(&b));
    }
}

#[test]
fn rays_are_counted_without_rendering() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["rays", "builtin:cornell", "--method", "distribution", "--size", "12x8"];
    let all = [&arguments[..], &FEW].concat();
    let text = well(folder.path(), &all).out;
    assert!(text.contains("at most 16 rays per pixel") && text.contains("upper bound"), "{text}");
    let json = well(folder.path(), &[&all[..], &["--json"]].concat()).json();
    assert_eq!(json["rays_per_pixel"], 16.0);
    assert_eq!(json["outer"], serde_json::json!({ "pixel": 2, "lens": 1, "time": 1 }));
    assert_eq!(json["depths"][0]["light"], 8.0);
    assert_eq!(json["depths"][1]["light"], 2.0);
    assert_eq!(json["depths"][2]["arriving"], 2.0);
    let path = ["rays", "builtin:cornell", "--spp", "4", "--max-bounces", "1", "--json"];
    // Camera ray, shadow ray, and continuation ray.
    assert_eq!(well(folder.path(), &path).json()["rays_per_pixel"], 12.0);
    assert!(files(folder.path()).is_empty());
}

#[test]
fn a_sheet_shows_counts_and_estimators() {
    let folder = tempfile::tempdir().unwrap();
    let soft_shadow = scene("soft_shadow.gltf");
    let sheet = ["sheet", soft_shadow.to_str().unwrap(), "--vary", "light", "--size", "48x32", "--json"];
    let counts = ["--counts", "1,16", "--estimators", "grid,random,stratified,sobol", "-o", "s.png"];
    let run = well(folder.path(), &[&sheet[..], &counts].concat());
    assert_eq!(files(folder.path()), ["s.png"]);
    assert!(run.err.contains("reference: path tracer, 256 samples"), "{}", run.err);
    let first = run.err.lines().find(|line| line.starts_with("forecast:")).unwrap();
    assert!(first.contains("8 cells about") && first.contains("its reference about"), "{first}");
    assert!(run.err.find("forecast:") < run.err.find("reference: path"));
    let json = run.json();
    let cells = json["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 8);
    let error = |i: usize| cells[i]["relative_rmse"].as_f64().unwrap();
    for row in [0, 2, 4, 6] {
        assert!(error(row + 1) < 0.6 * error(row), "{}: {} {}", cells[row], error(row), error(row + 1));
    }
    // With 16 samples, one sample per cell is better than independent samples.
    assert!(error(5) < error(3) && error(7) < error(3));
    let picture = read::picture(&folder.path().join("s.png")).unwrap();
    assert!(picture.width > 2 * 48 && picture.height > 4 * 32);
    // All cells have the same exposure, metered and printed once; requested explicitly, it gives the same sheet.
    let stops = json["exposure"].as_f64().unwrap() as f32;
    let said = format!("exposure of the sheet metered: {stops:+.2} stops (--exposure {stops} repeats it)");
    assert!(stops != 0.0 && run.err.matches(&said).count() == 1, "{}", run.err);
    let cell = |name: &str| {
        let sheet = read::picture(&folder.path().join(name)).unwrap();
        let place = |i: usize| 8 + i % 48 + (8 + i / 48) * sheet.width;
        (0..48 * 32).map(|i| sheet.pixels[place(i)]).collect::<Vec<_>>()
    };
    for (exposure, is_same) in [(stops, true), (stops - 2.0, false)] {
        let exposure = exposure.to_string();
        let again = ["--counts", "1", "--estimators", "grid", "-o", "t.png", "--exposure", &exposure];
        let run = well(folder.path(), &[&sheet[..], &again].concat());
        assert!(!run.err.contains("metered"), "{}", run.err);
        assert_eq!(cell("s.png") == cell("t.png"), is_same, "{exposure}");
    }
}

/// Under a sky all errors fall with those of the varied effect: random samples as n^-½, others faster. A sky sampled in
/// one direction would keep the errors up, on direct lighting, in blurred mirrors and in smooth ones.
#[test]
fn sheets_under_a_sky_fall_with_the_varied_effect() {
    let folder = tempfile::tempdir().unwrap();
    for (name, vary, size) in [("blurred_reflection", "glossy", "24x15"), ("environment", "light", "16x10")] {
        let scene = scene(&format!("{name}.gltf"));
        let sheet =
            ["sheet", scene.to_str().unwrap(), "--vary", vary, "--size", size, "--yes", "--json", "--quiet"];
        let counts = ["--counts", "4,64", "--estimators", "random,sobol,stratified,grid", "-o", "s.png"];
        let json = well(folder.path(), &[&sheet[..], &counts].concat()).json();
        let error = |i: usize| json["cells"][i]["relative_rmse"].as_f64().unwrap();
        let slope = |row: usize| (error(2 * row) / error(2 * row + 1)).ln() / 16f64.ln();
        let slopes = [0, 1, 2, 3].map(slope);
        assert!((0.42..0.58).contains(&slopes[0]), "{name}: {slopes:?}");
        // A grid is no better than that where edges are parallel to its cells.
        assert!(slopes[1..].iter().all(|s| (0.42..1.1).contains(s)), "{name}: {slopes:?}");
    }
}

/// Errors are measured against the file: a cell can be its own reference.
#[test]
fn a_sheet_takes_a_reference() {
    let folder = tempfile::tempdir().unwrap();
    let size = ["--size", "12x8", "--max-bounces", "2"];
    let off = [
        "--method",
        "distribution",
        "--pixel",
        "0",
        "--diffuse",
        "0",
        "--glossy",
        "0",
        "--light",
        "4:random",
    ];
    well(folder.path(), &[&["render", "builtin:cornell", "-o", "r.exr"], &size[..], &off].concat());
    let sheet = ["sheet", "builtin:cornell", "--vary", "light", "--counts", "4,5", "--estimators", "random"];
    let reference = ["--reference", "r.exr", "--max-bounces", "2", "--json", "-o", "s.png"];
    let json = well(folder.path(), &[&sheet[..], &reference].concat()).json();
    assert_eq!(json["reference"], "r.exr");
    assert_eq!(json["cells"][0]["relative_rmse"], 0.0);
    assert!(json["cells"][1]["relative_rmse"].as_f64().unwrap() > 0.0);
}

/// The noise of the reference is excluded from the errors: with two noisy halves, a converged cell has no error beyond
/// what the noise hides; with one half alone, the error is its noise.
#[test]
fn a_sheet_subtracts_the_noise_of_its_reference() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene("soft_shadow.gltf").display().to_string();
    let off = ["--method", "distribution", "--pixel", "0", "--diffuse", "0", "--light", "4:random"];
    for (name, seed) in [("r1.exr", "5"), ("r2.exr", "6")] {
        let more = ["--size", "128x96", "--seed", seed, "-o", name];
        well(folder.path(), &[&["render", &scene], &off[..], &more].concat());
    }
    let base = ["sheet", &scene, "--vary", "light", "--counts", "4,256", "--estimators", "random", "--json"];
    let of = |more: &[&str]| well(folder.path(), &[&base[..], more].concat()).json()["cells"].take();
    let one = of(&["--reference", "r1.exr"]);
    let two = of(&["--reference", "r1.exr", "--reference-half", "r2.exr"]);
    let error = |cells: &serde_json::Value, i: usize| cells[i]["relative_rmse"].as_f64();
    let (noisy, fair) = (error(&one, 0).unwrap(), error(&two, 0).unwrap());
    // As noisy as the cell: twice the squared error.
    assert!((noisy / fair - 2f64.sqrt()).abs() < 0.15, "{noisy} {fair}");
    let best = error(&two, 1).or(two[1]["relative_rmse_below"].as_f64()).unwrap();
    assert!(best < 0.4 * fair && error(&one, 1).unwrap() > 0.8 * fair, "{best} {fair} {one}");
}

/// A sheet ends at its time limit, with the finished cells and a message; so does its reference.
#[test]
fn a_sheet_obeys_the_time_limit() {
    let folder = tempfile::tempdir().unwrap();
    let base = ["sheet", "builtin:cornell", "--vary", "light", "--estimators", "random", "--size", "64x64"];
    let arguments = ["--counts", "1,4,3000", "--time-limit", "1s", "--json", "-o", "s.png"];
    let start = std::time::Instant::now();
    let found = run(folder.path(), &[&base[..], &arguments].concat());
    assert_eq!(found.code, 3, "{}", found.err);
    assert!(found.err.contains("--time-limit 1 s") && found.err.contains("stopped early: the sheet has"));
    // Without the limit, the last cell and its reference take minutes.
    assert!(start.elapsed().as_secs_f64() < 60.0);
    let json = found.json();
    let last = &json["cells"][2];
    assert_eq!((&last["rendered"], &last["relative_rmse"]), (&false.into(), &serde_json::Value::Null));
    assert_eq!(json["cells"].as_array().unwrap().len(), 3);
    let picture = read::picture(&folder.path().join("s.png")).unwrap();
    assert!(picture.width > 3 * 64);
    // With enough time, the sheet is complete.
    let enough = ["--counts", "1,2", "--time-limit", "100s", "--json", "-o", "s.png"];
    let json = well(folder.path(), &[&base[..], &enough].concat()).json();
    assert!(json["cells"].as_array().unwrap().iter().all(|cell| cell["rendered"] == true));
    assert!(json["reference_relative_rmse"].as_f64().unwrap() > 0.0);
}

#[test]
fn a_scene_without_an_effect_makes_no_sheet() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.gltf"), triangle(|_, _| {})).unwrap();
    let run = run(folder.path(), &["sheet", "scene.gltf", "--vary", "lens", "--counts", "1"]);
    assert_eq!(run.code, 2);
    assert!(run.err.contains("--vary lens") && run.err.contains("--aperture-radius"), "{}", run.err);
    assert_eq!(files(folder.path()), ["scene.gltf"]);
}
