//! Usability of the command line: help, rejected options, and suggestions for misspelt names.

mod dapple;

use dapple::{files, run, scene, well};
use dapple_imaging::read;
use std::fs;
use std::path::Path;

const SMALL: [&str; 4] = ["--size", "8x8", "--spp", "1"];

/// Runs; expects exit code 2 and one line on standard error that contains each of `parts`.
fn complains(arguments: &[&str], parts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let run = run(folder.path(), arguments);
    assert_eq!((run.code, run.out.as_str()), (2, ""), "{arguments:?}: {}", run.err);
    assert_eq!(run.err.trim_end().lines().count(), 1, "{arguments:?}: {}", run.err);
    assert!(run.err.starts_with("error: "), "{arguments:?}: {}", run.err);
    for part in parts {
        assert!(run.err.contains(part), "{arguments:?}: '{part}' is not in: {}", run.err);
    }
    assert!(files(folder.path()).is_empty(), "{arguments:?}");
}

/// Returns the long names that a help page lists.
fn listed(page: &str) -> Vec<String> {
    let line = |line: &str| {
        let line = line.trim_start();
        let name = line
            .strip_prefix("--")
            .or_else(|| line.get(4..)?.strip_prefix("--").filter(|_| line.starts_with('-')));
        let name = name?.split(|c: char| !c.is_ascii_lowercase() && c != '-').next()?;
        (!name.is_empty()).then(|| name.to_string())
    };
    page.lines().filter_map(line).collect()
}

fn help(arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    well(folder.path(), arguments).out
}

#[test]
fn names_of_other_programs_lead_to_ours() {
    for (typed, meant) in [
        ("--sample", "did you mean --spp?"),
        ("--samples-per-pixel", "did you mean --spp?"),
        ("--sppp", "did you mean --spp?"),
        ("--width", "did you mean --size, as WIDTHxHEIGHT such as 640x480?"),
        ("--height", "did you mean --size, as"),
        ("--resolution", "did you mean --size?"),
        ("--szie", "did you mean --size?"),
        ("--bounces", "did you mean --max-bounces?"),
        ("--depth", "did you mean --max-bounces?"),
        ("--max_bounces", "did you mean --max-bounces?"),
        ("--out", "did you mean --output?"),
        ("--outptu", "did you mean --output?"),
        ("--sampler", "did you mean --pattern?"),
        ("--integrator", "did you mean --method?"),
        ("--timeout", "did you mean --time-limit?"),
        ("--noise-threshold", "did you mean --error-limit?"),
        ("--hdri", "did you mean --env?"),
        ("--background", "did you mean --env-color?"),
        ("--tonemapping", "did you mean --tone?"),
        ("--Tone", "did you mean --tone?"),
        ("--jobs", "did you mean --threads?"),
        ("--region", "did you mean --crop?"),
        ("--config", "did you mean --settings?"),
        ("--counts", "--counts"),
        ("--bounce", "did you mean --max-bounces?"),
        ("--sampels", "--spp"),
        ("--no-half", "--half=false"),
        ("--zzzzz", "see dapple render --help"),
    ] {
        complains(&["render", "builtin:cornell", typed, "9"], &[&format!("unknown option '{typed}'"), meant]);
        let joined = format!("{typed}=9");
        complains(&["render", "builtin:cornell", &joined], &[&format!("unknown option '{typed}'"), meant]);
    }
    complains(&["render", "--counts", "3"], &["--counts", "it is an option of sheet"]);
    complains(&["--spp", "3"], &["--spp", "dapple render"]);
    complains(&["render", "builtin:cornell", "--time", "30s"], &["--time", "--time-limit"]);
    complains(&["render", "builtin:cornell", "--half", "false"], &["--half=false"]);
    complains(&["render", "--spp", "3", "--spp", "4"], &["--spp <N>", "give it only once"]);
    complains(&["render", "--spp"], &["--spp <N> needs a value", "Samples per pixel"]);
    complains(&["render", "--spp", "4.5"], &["'4.5'", "--spp <N>", "expected a whole number"]);
    complains(&["sheet", "--output"], &["--output <FILE> needs a value (Output file, a .png"]);
    complains(&["info", "builtin:spheres"], &["did you mean builtin:cornell-spheres?"]);
    complains(&["info"], &["<SCENE>", "builtin:cornell-spheres"]);
    complains(&["sheet", "builtin:cornell", "--vary", "light"], &["--counts <LIST>", "Sample counts"]);
    complains(
        &["diff", "a.exr", "b.exr", "--map", "signd"],
        &["relative, signed, flip", "did you mean signed?"],
    );
    complains(&["render", "builtin:cornel"], &["did you mean builtin:cornell?", "builtin:furnace"]);
    let long = format!("--{}", "x".repeat(3000));
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&["render", &long][..], &["render", "--spp", &long[2..]], &[&long[2..]]] {
        let run = run(folder.path(), arguments);
        assert!(run.code == 2 && run.err.len() < 400, "{}", run.err);
    }
}

/// Options of other programs that do not exist here are answered with an alternative, also after a file name.
#[test]
fn what_there_is_not_has_an_answer() {
    for (typed, meant) in [
        ("--list", "dapple info"),
        ("--denoise", "--error-limit"),
        ("--no-env", "--env none"),
        ("--position", "--look-from, the camera position"),
        ("--sppp", "--spp"),
        ("--num-samples", "--spp"),
        ("--szie=3x3", "--size"),
    ] {
        let name = typed.split('=').next().unwrap();
        for before in [&[][..], &["render"], &["render", "a.glb"], &["a.glb"], &["builtin:cornell"]] {
            complains(&[before, &[typed]].concat(), &[&format!("unknown option '{name}'"), meant]);
        }
    }
    complains(&["builtin:cornell", "--vary", "light"], &["it is an option of sheet"]);
}

#[test]
fn values_have_other_names() {
    let folder = tempfile::tempdir().unwrap();
    let render = |name: &str, aov: &str| {
        let small = ["builtin:cornell", "--size=4x4", "--spp=1", "--backfaces=cull", "-o"];
        well(folder.path(), &[&small[..], &[name, "--aov", aov]].concat());
        read::layers(&folder.path().join(name)).unwrap()
    };
    assert_eq!(render("a.exr", "z,crypto"), render("b.exr", "depth,cryptomatte"));
    let all = "beauty,albedo,normal,depth,position,variance,samples,object,material,removed,cryptomatte";
    assert_eq!(render("c.exr", "All"), render("d.exr", all));
}

#[test]
fn misspelt_commands_are_recognised() {
    for (typed, meant) in [
        ("rendr", "dapple render"),
        ("Render", "dapple render"),
        ("compare", "dapple diff"),
        ("benchmark", "dapple converge"),
        ("completion", "dapple completions"),
        ("inspect", "dapple info"),
        ("reply", "dapple replay"),
        ("sing", "render, info, plan"),
    ] {
        complains(&[typed], &[&format!("unknown command '{typed}'"), meant]);
    }
    complains(&["man", "rendr"], &["did you mean dapple render?"]);
}

/// The arguments of each command, and an option that has no effect on it.
#[test]
fn options_that_do_nothing_are_refused() {
    let cornell = "builtin:cornell";
    let replay: &[&str] = &["replay", cornell, "--pixel", "0,0", "--sample", "0"];
    let sheet: &[&str] = &["sheet", cornell, "--vary", "light", "--counts", "1"];
    for (command, typed) in [
        (&["plan", cornell][..], &["--half"][..]),
        (&["plan", cornell], &["--exposure", "1"]),
        (&["plan", cornell], &["--tone", "agx"]),
        (&["plan", cornell], &["--log", "a.jsonl"]),
        (&["plan", cornell], &["--quiet"]),
        (&["rays", cornell], &["--seed", "1"]),
        (&["rays", cornell], &["--threads", "2"]),
        (&["rays", cornell], &["--tone", "agx"]),
        (&["rays", cornell], &["--pattern", "sobol"]),
        (&["rays", cornell], &["--filter", "tent"]),
        (&["budget", cornell, "--error-limit", "0.1"], &["--output", "a.exr"]),
        (&["budget", cornell, "--error-limit", "0.1"], &["--spp", "4"]),
        (&["budget", cornell, "--error-limit", "0.1"], &["--adaptive"]),
        (replay, &["-o", "a.exr"]),
        (replay, &["--clamp", "3"]),
        (replay, &["--aov", "depth"]),
        (replay, &["--confidence", "0.9"]),
        (sheet, &["--pattern", "sobol"]),
        (sheet, &["--method", "path"]),
        (sheet, &["--half"]),
        (sheet, &["--log", "a.jsonl"]),
        (sheet, &["--error-limit", "0.1"]),
        (&["converge", cornell, "-o", "out"], &["--spp", "4"]),
        (&["converge", cornell, "-o", "out"], &["--half"]),
        (&["converge", cornell, "-o", "out"], &["--time-limit", "3s"]),
        (&["converge", cornell, "-o", "out"], &["--crop", "0,0,1,1"]),
    ] {
        let name = if typed[0] == "-o" { "--output" } else { typed[0] };
        complains(&[command, typed].concat(), &[&format!("{name}: not available for {}", command[0])]);
        let page = help(&[command[0], "--help"]);
        assert!(!listed(&page).contains(&name[2..].to_string()), "{} lists {name}", command[0]);
    }
    complains(&["info", cornell, "--spp", "4"], &["--spp", "not available for info"]);
    complains(&["diff", "a.exr", "b.exr", "--size", "8x8"], &["--size", "not available for diff"]);
    complains(&["verify", "--threads", "2"], &["--threads", "not available for verify"]);
    complains(&["stress", "--spp", "2"], &["--spp", "not available for stress"]);
    let run = ["converge", cornell, "-o", "out", "--size", "8x8", "--run", "a: --half"];
    let folder = tempfile::tempdir().unwrap();
    let refused = dapple::run(folder.path(), &run);
    assert!(
        refused.code == 2 && refused.err.contains("--run a: --half: not available for converge"),
        "{}",
        refused.err
    );
}

#[test]
fn settings_files_may_serve_many_commands() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.toml"), "size = '8x8'\nhalf = true\ntone = 'agx'\nspp = 2\n").unwrap();
    let rays = well(folder.path(), &["rays", "builtin:cornell", "--settings", "mine.toml", "--json"]);
    assert_eq!(rays.err, "note: mine.toml: half, tone: ignored, because dapple rays does not use it\n");
    assert_eq!(rays.json()["width"], 8);
    for (key, said) in [("sample", "did you mean spp?"), ("szie", "did you mean size?"), ("width", "size?")] {
        fs::write(folder.path().join("bad.toml"), format!("{key} = 3\n")).unwrap();
        let run = run(folder.path(), &["render", "--settings", "bad.toml"]);
        assert!(run.code == 2 && run.err.contains(key) && run.err.contains(said), "{}", run.err);
    }
}

#[test]
fn help_is_short_for_newcomers_and_full_for_others() {
    let (short, full) = (help(&["render", "-h"]), help(&["render", "--help"]));
    assert!(short.lines().count() < 48, "{short}");
    for name in ["output", "size", "spp", "env", "exposure", "method", "time-limit"] {
        assert!(listed(&short).contains(&name.to_string()), "{name}: {short}");
    }
    assert!(short.contains("All options: dapple render --help"), "{short}");
    assert!(!listed(&short).contains(&"no-soft-terminator".into()) && full.len() > 3 * short.len());
    for heading in ["Output:", "Sampling:", "Effects:", "Lens:", "View:", "Environment:", "General:"] {
        assert!(full.contains(heading), "{heading}");
    }
    for page in [&short, &full] {
        assert!(
            ["cornell", "cornell-spheres", "furnace"].iter().all(|n| page.contains(&format!("builtin:{n}")))
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let commands = well(folder.path(), &["--help"]).out;
    let names = commands.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| !l.is_empty());
    let names: Vec<&str> = names.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() >= 12, "{commands}");
    for name in names.into_iter().filter(|name| *name != "help") {
        let page = help(&[name, "-h"]);
        assert!(page.lines().count() < 60 && page.contains("Usage: dapple"), "{name}: {page}");
    }
}

#[test]
fn values_have_usual_names() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |name: &str, more: &[&str]| {
        let base =
            ["render", "builtin:cornell", "--size", "8x8", "--spp", "4", "--exposure", "2", "-o", name];
        well(folder.path(), &[&base, more].concat());
        fs::read(folder.path().join(name)).unwrap()
    };
    for (said, meant, other) in [
        (["--tone", "AGX"], ["--tone", "agx"], ["--tone", "aces"]),
        (["--tone", "Standard"], ["--tone", "srgb"], ["--tone", "aces"]),
        (["--pattern", "jittered"], ["--pattern", "stratified"], ["--pattern", "random"]),
        (["--pattern", "Owen"], ["--pattern", "sobol"], ["--pattern", "random"]),
        (["--filter", "Triangle"], ["--filter", "tent"], ["--filter", "gaussian"]),
        (["--method", "Distributed"], ["--method", "distribution"], ["--method", "path"]),
    ] {
        let with = |values: [&str; 2]| bytes("a.png", &values);
        assert!(with(said) == with(meant) && with(said) != with(other), "{said:?}");
    }
    let plan = |plan: &str| bytes("a.png", &["--method", "distribution", "--light", plan]);
    assert!(plan("2X2:Jittered") == plan("2x2:stratified") && plan("2x2:stratified") != plan("2x2:random"));
    complains(&["render", "--pattern", "halton"], &["halton", "grid, random, stratified or sobol"]);
}

#[test]
fn what_changes_nothing_here_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for (typed, said) in [
        (&["--half", "-o", "a.png"][..], "--half is ignored: no EXR"),
        (&["--tone", "agx", "-o", "a.exr"], "--tone is ignored: no PNG"),
        (&["--combine", "paired"], "--combine is ignored: the path tracer"),
        (&["--env-rotation", "90"], "--env-rotation is ignored: there is no environment map"),
        (&["--shutter", "0:1"], "--shutter is ignored: nothing moves"),
        (&["--method", "distribution", "--no-roulette"], "--no-roulette is ignored"),
    ] {
        let run =
            well(folder.path(), &[&["render", "builtin:cornell", "--quiet"], &SMALL[..], typed].concat());
        assert!(run.err.contains(&format!("note: {said}")), "{typed:?}: {}", run.err);
        assert_eq!(run.err.lines().count(), 1, "{typed:?}: {}", run.err);
    }
}

#[test]
fn verbose_is_prose() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene("cornell.gltf");
    let arguments = ["render", scene.to_str().unwrap(), "-v", "--quiet", "--threads", "1", "-o", "a.exr"];
    let run = well(folder.path(), &[&arguments[..], &SMALL].concat());
    for sentence in [
        "The scene has 38 triangles",
        "Rendering 8x8 pixels, by the path tracer with Russian roulette: 1 sample per pixel",
        "16 scattering events; box filter; seed 0 on 1 thread.",
        "Writing a.exr.",
    ] {
        assert!(run.err.contains(sentence), "{sentence}: {}", run.err);
    }
    assert!(
        run.err.lines().all(|line| line.ends_with('.') && !line.contains(['{', '}', '\u{1b}'])),
        "{}",
        run.err
    );
    let silent = well(folder.path(), &[&["render", "-q", "-o", "a.exr"], &SMALL[..]].concat());
    assert_eq!(silent.err, "");
}

/// Standard error is a pipe here.
#[test]
fn no_bar_is_drawn_where_nobody_looks() {
    let folder = tempfile::tempdir().unwrap();
    let run = well(folder.path(), &["render", "--size", "64x64", "--spp", "64"]);
    assert!(!run.err.contains(['\r', '\u{1b}', '█', '░']) && run.err.lines().count() <= 5, "{}", run.err);
}

#[cfg(feature = "manual")]
#[test]
fn shells_complete() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = well(folder.path(), &["completions", shell]).out;
        for word in ["dapple", "render", "converge", "max-bounces", "completions"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    // Checked by the shell itself, if it is available.
    let script = well(folder.path(), &["completions", "bash"]).out;
    fs::write(folder.path().join("dapple.bash"), &script).unwrap();
    if let Ok(status) =
        std::process::Command::new("bash").arg("-n").arg(folder.path().join("dapple.bash")).status()
    {
        assert!(status.success());
    }
    // Options that a command does not use are not completed.
    let rays = script
        .split("dapple__subcmd__rays)")
        .nth(1)
        .or_else(|| script.split("dapple__rays)").nth(1))
        .unwrap();
    let offered = rays.split("opts=\"").nth(1).unwrap().split('"').next().unwrap();
    assert!(offered.contains("--pixel") && !offered.contains("--half"), "{offered}");
    complains(&["completions", "tcsh"], &["bash, elvish, fish, powershell, zsh"]);
}

#[cfg(feature = "manual")]
#[test]
fn manual_pages_are_made() {
    let folder = tempfile::tempdir().unwrap();
    let page = well(folder.path(), &["man"]).out;
    assert!(page.contains(".TH dapple 1") && page.contains("converge"), "{page}");
    let page = well(folder.path(), &["man", "render"]).out;
    assert!(page.contains(".TH dapple\\-render 1") || page.contains(".TH dapple-render 1"), "{page}");
    assert!(page.contains("\\-\\-spp") && page.contains("builtin:cornell"), "{page}");
    assert!(well(folder.path(), &["man", "-o", "."]).out.is_empty());
    let pages = files(folder.path());
    for name in ["dapple.1", "dapple-render.1", "dapple-info.1", "dapple-man.1", "dapple-completions.1"] {
        assert!(pages.contains(&name.to_string()), "{pages:?}");
    }
    assert_eq!(fs::read_to_string(folder.path().join("dapple-render.1")).unwrap(), page);
    well(folder.path(), &["man", "-o", "new/pages"]);
    assert_eq!(fs::read_to_string(folder.path().join("new/pages/dapple-render.1")).unwrap(), page);
    fs::write(folder.path().join("file"), "").unwrap();
    let run = run(folder.path(), &["man", "-o", "file"]);
    assert!(run.code == 2 && run.err.contains("-o file: cannot be created"), "{}", run.err);
}

/// The default image: the mean is a middle grey, and little apart from the lamp is white.
#[test]
fn the_default_picture_is_bright() {
    let folder = tempfile::tempdir().unwrap();
    well(folder.path(), &["render", "--size", "48x48", "-o", "a.png"]);
    let picture = read::picture(&folder.path().join("a.png") as &Path).unwrap();
    let mean =
        picture.pixels.iter().map(|p| p.element_sum() / 3.0).sum::<f32>() / picture.pixels.len() as f32;
    assert!((0.18..0.5).contains(&mean), "{mean}");
    let white = picture.pixels.iter().filter(|p| p.min_element() >= 1.0).count();
    assert!(white * 20 < picture.pixels.len(), "{white}");
}

#[test]
fn the_stress_catalogue_can_be_listed() {
    let folder = tempfile::tempdir().unwrap();
    let all = well(folder.path(), &["stress", "--list"]).out;
    assert!(all.lines().count() > 60 && all.starts_with("A01  "), "{all}");
    let some = well(folder.path(), &["stress", "--list", "--case", "D*"]).out;
    assert!(some.lines().all(|line| line.starts_with('D')) && some.lines().count() > 10, "{some}");
}

#[test]
fn an_option_in_the_place_of_the_command_renders() {
    let folder = tempfile::tempdir().unwrap();
    let words = [&["-q", "builtin:cornell", "-o", "a.png"][..], &SMALL].concat();
    well(folder.path(), &words);
    assert_eq!(files(folder.path()), ["a.png"]);
}

/// What a file beside the scene sets is printed, and a misspelt key is not called forbidden.
#[test]
fn settings_beside_a_scene_are_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.gltf"), dapple::triangle(|_, _| ())).unwrap();
    fs::write(folder.path().join("s.toml"), "spp = 2\nmax-bounces = 1\nsppp = 3\nlog = 'x'\n").unwrap();
    let base = ["render", "s.gltf", "--size", "8x8", "--crop", "0,0,4,2", "-o", "a.png"];
    let said = well(folder.path(), &base).err;
    for part in [
        "note: s.toml sets max-bounces, spp",
        "ignored 'log'; a settings file beside the scene cannot set these",
        "ignored 'sppp'; there are no such options",
        "8x8 cropped to 4x2 at 0,0, 2 samples per pixel",
    ] {
        assert!(said.contains(part), "'{part}' is not in: {said}");
    }
}
