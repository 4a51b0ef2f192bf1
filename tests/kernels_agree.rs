//! Omitting features changes no bit: the chosen plan and the general one give the same file, for every scene and both
//! methods.

mod dapple;

use dapple::{files, scene, well};

fn agree(method: &[&str]) {
    let scenes = scene("");
    for name in files(&scenes).iter().filter(|name| name.ends_with(".gltf")) {
        let folder = tempfile::tempdir().unwrap();
        let path = scene(name);
        let render = |plan: &str, file: &str| {
            let path = path.to_str().unwrap();
            let fixed = ["render", path, "--size", "20x14", "--quiet", "--plan", plan, "-o", file];
            let all: Vec<&str> = fixed.iter().chain(method).copied().collect();
            well(folder.path(), &all);
            std::fs::read(folder.path().join(file)).unwrap()
        };
        assert!(
            render("smallest", "a.exr") == render("general", "b.exr"),
            "{name} {method:?}: the files differ"
        );
    }
}

#[test]
fn paths() {
    agree(&["--spp", "4"]);
}

#[test]
fn paths_with_effects_off() {
    agree(&["--spp", "3", "--light", "0", "--glossy", "0", "--diffuse", "0"]);
}

#[test]
fn layers() {
    agree(&["--spp", "2", "--max-bounces", "0", "--aov", "beauty,depth,normal,albedo"]);
}

#[test]
fn layers_without_the_picture() {
    agree(&["--spp", "2", "--aov", "depth,normal,position,object"]);
}

#[test]
fn distribution() {
    let counts = ["--pixel", "2", "--light", "2", "--glossy", "2", "--lens", "2", "--time", "2"];
    agree(&[&["--method", "distribution", "--max-bounces", "2", "--yes"][..], &counts].concat());
}
