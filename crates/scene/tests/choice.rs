//! Selection of scenes, material variants and animations of a file by name or index, and their listing by `info`.
#![cfg(feature = "gltf")]
mod file;

use dapple_scene::{Scene, SceneBuilder, SceneError, gltf};
use file::{File, json};
use glam::{DVec3, Vec3};
use serde_json::Value;
use std::path::Path;

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

fn choice(scene: &str, variant: &str, animation: &str) -> gltf::Choice {
    let some = |text: &str| (!text.is_empty()).then(|| text.to_owned());
    gltf::Choice { scene: some(scene), variant: some(variant), animation: some(animation) }
}

fn options(choice: gltf::Choice, at: f64) -> gltf::Options {
    gltf::Options { at, choice, ..gltf::Options::default() }
}

fn read(file: &File, options: &gltf::Options) -> Result<SceneBuilder, SceneError> {
    gltf::read_bytes(Path::new("test.gltf"), &file.gltf(), options)
}

fn load(file: &File, choice: gltf::Choice, at: f64) -> Scene {
    read(file, &options(choice, at)).and_then(SceneBuilder::build).unwrap_or_else(|e| panic!("{e}"))
}

/// The message of the error for a choice that does not exist; checks its type.
fn refused(file: &File, choice: gltf::Choice) -> String {
    let error = read(file, &options(choice, 0.0)).expect_err("this choice does not exist");
    let text = error.to_string();
    assert!(matches!(error, SceneError::Choice { .. }), "{text}");
    assert!(text.starts_with("test.gltf: --") && text.lines().count() == 1, "{text}");
    text
}

fn corner(scene: &Scene, object: u32) -> DVec3 {
    scene.space.to_world(scene.accel.corners(object, 0)[0]).0
}

fn info(file: &File, options: &gltf::Options) -> Result<gltf::Info, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test.gltf");
    std::fs::write(&path, file.gltf()).unwrap();
    gltf::info(&path, options)
}

/// A file whose nodes 0 to 3 are squares at x = 0 to 3.
fn squares() -> File {
    let mut file = File::new();
    let positions = file.floats(&SQUARE);
    let indices = file.indices_u16(&[0, 1, 2, 0, 2, 3]);
    let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices});
    file.set("meshes", json!([{"primitives": [primitive]}]));
    let nodes: Vec<Value> = (0..4).map(|x| json!({"mesh": 0, "translation": [x, 0, 0]})).collect();
    file.set("nodes", json!(nodes));
    file
}

fn scenes(names: &[&str]) -> File {
    let mut file = squares();
    let scene = |(i, name): (usize, &&str)| match name.is_empty() {
        true => json!({"nodes": [i]}),
        false => json!({"nodes": [i], "name": name}),
    };
    file.set("scenes", names.iter().enumerate().map(scene).collect());
    file
}

#[test]
fn scenes_by_name_and_index() {
    let mut file = scenes(&["", "two", "0", "two"]);
    let shown = |file: &File, scene: &str| corner(&load(file, choice(scene, "", ""), 0.0), 0).x;
    // A name takes precedence over an index; of several with the same name the first one is used.
    for (scene, x) in [("", 0.0), ("1", 1.0), ("two", 1.0), ("0", 2.0), ("3", 3.0)] {
        assert!((shown(&file, scene) - x).abs() < 1e-6, "{scene}");
    }
    let warnings = |scene| load(&file, choice(scene, "", ""), 0.0).warnings;
    assert!(warnings("two").iter().any(|w| w.0.contains("2 scenes are named 'two' (1, 3): scene 1 is used")));
    assert!(!warnings("3").iter().any(|w| w.0.contains("are named")));
    for wrong in ["4", "-1", "Two", "two ", "1.0", "scene 1"] {
        let said = refused(&file, choice(wrong, "", ""));
        assert!(said.contains(&format!("--scene {wrong}: ")), "{said}");
        assert!(said.ends_with("the file has 0, 1 'two', 2 '0', 3 'two'"), "{said}");
    }
    file.set("scene", json!(3));
    assert!((shown(&file, "") - 3.0).abs() < 1e-6);
    file.json.as_object_mut().unwrap().remove("scene");
    assert!(shown(&file, "").abs() < 1e-6, "without a default scene the first one is shown");
    // An invalid default scene does not matter if another one is selected.
    file.set("scene", json!(9));
    assert!((shown(&file, "3") - 3.0).abs() < 1e-6);
    assert!(read(&file, &options(choice("", "", ""), 0.0)).is_err());
    file.set("scenes", json!([]));
    file.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(load(&file, choice("", "", ""), 0.0).survey.objects, 4);
    assert!(refused(&file, choice("0", "", "")).ends_with("the file has none"));
}

#[test]
fn what_else_there_is_is_noted_unless_it_was_chosen() {
    let file = variants();
    let notes = |choice| read(&file, &options(choice, 0.0)).unwrap().notes().join("\n");
    assert_eq!(
        notes(choice("", "", "")),
        "no material variant is used; the file has 0 'gold', 1 'blue', 2 (--variant)"
    );
    assert_eq!(notes(choice("", "1", "")), "");
    let file = scenes(&["", "two"]);
    let notes = |choice| read(&file, &options(choice, 0.0)).unwrap().notes().join("\n");
    assert_eq!(notes(choice("", "", "")), "scene 0 is shown; the file also has 1 'two' (--scene)");
    assert_eq!(notes(choice("two", "", "")), "");
    let file = moving();
    let notes = |choice| read(&file, &options(choice, 0.0)).unwrap().notes().join("\n");
    assert_eq!(
        notes(choice("", "", "")),
        "animation 0 'right' is selected; the file also has 1 'up', 2 (--animation, or all)"
    );
    assert_eq!(notes(choice("", "", "all")), "");
    assert_eq!(read(&squares(), &gltf::Options::default()).unwrap().notes().len(), 0);
    // The length of the line is bounded.
    let mut many = squares();
    many.set("scenes", json!(vec![json!({"nodes": [0], "name": "y".repeat(500)}); 3000]));
    let note = read(&many, &gltf::Options::default()).unwrap().notes().join("\n");
    assert!(note.len() < 3000 && note.contains("and 2979 more"), "{note}");
}

/// Three primitives: one without mappings, one with several, one whose mapping lists two variants; and a sphere with
/// the material of the second one. The third variant has no name and no mappings.
fn variants() -> File {
    let mut file = squares();
    let plain = file.json["meshes"][0]["primitives"][0].clone();
    let mapped = |material: u32, mappings: Value| {
        let mut primitive = plain.clone();
        primitive["material"] = json!(material);
        primitive["extensions"] = json!({"KHR_materials_variants": {"mappings": mappings}});
        primitive
    };
    let each = json!([{"material": 1, "variants": [0]}, {"material": 2, "variants": [1], "name": "x"}]);
    let both = json!([{"material": 3, "variants": [9, 1, 0]}]);
    file.set(
        "meshes",
        json!([{"primitives": [plain.clone(), mapped(0, each.clone()), mapped(1, both)]}, {"primitives": [mapped(0, each)]}]),
    );
    file.set(
        "nodes",
        json!([{"mesh": 0}, {"mesh": 1, "extras": {"dapple": {"shape": "sphere", "radius": 1}}}]),
    );
    file.set("scenes", json!([{"nodes": [0, 1]}]));
    let names = ["own", "golden", "blue", "either"];
    file.set("materials", names.iter().map(|name| json!({"name": name})).collect());
    let list = json!([{"name": "gold"}, {"name": "blue"}, {}]);
    file.set("extensions", json!({"KHR_materials_variants": {"variants": list}}));
    file
}

#[test]
fn variants_give_primitives_other_materials() {
    let file = variants();
    let names = |variant| {
        let scene = load(&file, choice("", variant, ""), 0.0);
        let name = |i: usize| scene.materials[scene.objects[i].material as usize].name.to_string();
        (0..scene.objects.len()).map(name).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(names(""), "default own golden own");
    assert_eq!(names("gold"), "default golden either golden");
    assert_eq!(names("0"), names("gold"));
    assert_eq!(names("1"), "default blue either blue");
    assert_eq!(names("2"), names(""), "a variant without mappings changes no material");
    for wrong in ["3", "9", "Gold", "green"] {
        let said = refused(&file, choice("", wrong, ""));
        assert!(said.ends_with("the file has 0 'gold', 1 'blue', 2"), "{said}");
    }
    assert!(refused(&squares(), choice("", "0", "")).ends_with("the file has none"));
    let mut broken = variants();
    broken.json["meshes"][0]["primitives"][1]["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] =
        json!(44);
    assert!(read(&broken, &gltf::Options::default()).is_ok(), "a mapping that is not used does not matter");
    let said = read(&broken, &options(choice("", "gold", ""), 0.0)).unwrap_err().to_string();
    assert!(said.contains("refers to material 44"), "{said}");
}

/// Two animations that move node 0 along x and y, and one that rotates it about z and moves node 1 along y.
fn moving() -> File {
    let mut file = squares();
    let times = file.scalars(&[0.0, 2.0]);
    let later = file.scalars(&[1.0, 4.0]);
    let right = file.floats(&[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0_f32]]);
    let up = file.floats(&[[0.0, 0.0, 0.0], [0.0, 2.0, 0.0_f32]]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turned = file.floats(&[[0.0, 0.0, half, half]; 2]);
    let moves = |output: usize, node: usize| {
        json!({"samplers": [{"input": times, "output": output}],
               "channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}]})
    };
    let (mut first, mut second) = (moves(right, 0), moves(up, 0));
    first["name"] = json!("right");
    second["name"] = json!("up");
    let mut third = moves(up, 1);
    third["samplers"].as_array_mut().unwrap().push(json!({"input": later, "output": turned}));
    let turn = json!({"sampler": 1, "target": {"node": 0, "path": "rotation"}});
    third["channels"].as_array_mut().unwrap().push(turn);
    file.set("animations", json!([first, second, third]));
    file.set("scenes", json!([{"nodes": [0, 1]}]));
    file
}

#[test]
fn animations_alone_and_together() {
    let file = moving();
    // The second corner of each square, which rotates.
    let second = |animation: &str, object: u32| {
        let scene = load(&file, choice("", "", animation), 1.0);
        let p = scene.space.to_world(scene.accel.corners(object, 0)[1]).0;
        (p.x.round(), p.y.round())
    };
    for (animation, first_node, second_node) in [
        ("", (2.0, 0.0), (2.0, 0.0)),
        ("right", (2.0, 0.0), (2.0, 0.0)),
        ("0", (2.0, 0.0), (2.0, 0.0)),
        ("up", (1.0, 1.0), (2.0, 0.0)),
        ("2", (0.0, 1.0), (1.0, 1.0)),
        ("all", (1.0, 1.0), (1.0, 1.0)),
    ] {
        assert_eq!((second(animation, 0), second(animation, 1)), (first_node, second_node), "{animation}");
    }
    let hidden = |animation: &str| {
        let warnings = load(&file, choice("", "", animation), 1.0).warnings;
        warnings.iter().filter(|w| w.0.contains("an earlier animation moves as well")).count()
    };
    assert_eq!([hidden(""), hidden("up"), hidden("all")], [0, 0, 1]);
    for wrong in ["3", "All", "left"] {
        let said = refused(&file, choice("", "", wrong));
        assert!(said.ends_with("the file has 0 'right', 1 'up', 2"), "{said}");
    }
    assert_eq!(
        load(&squares(), choice("", "", "all"), 0.0).survey.objects,
        1,
        "`all` is valid without animations"
    );
    assert!(refused(&squares(), choice("", "", "0")).ends_with("the file has none"));
    // Errors in an animation that is not played do not matter.
    let mut broken = moving();
    broken.json["animations"][1]["samplers"][0]["output"] = json!(99);
    assert!(read(&broken, &options(choice("", "", ""), 0.0)).is_ok());
    assert!(read(&broken, &options(choice("", "", "up"), 0.0)).is_err());
}

#[test]
fn info_lists_what_there_is_to_choose_from() {
    let told = info(&scenes(&["", "two"]), &gltf::Options::default()).unwrap();
    let scenes: Vec<_> =
        told.scenes.iter().map(|s| (s.index, s.name.as_deref(), s.default, s.shown)).collect();
    assert_eq!(scenes, [(0, None, true, true), (1, Some("two"), false, false)]);
    let told = info(&variants(), &options(choice("", "blue", ""), 0.0)).unwrap();
    let all: Vec<_> = told.variants.iter().map(|v| (v.name.as_deref(), v.primitives, v.shown)).collect();
    assert_eq!(all, [(Some("gold"), 3, false), (Some("blue"), 3, true), (None, 0, false)]);
    let mut file = moving();
    file.json["animations"][1]["samplers"][0]["input"] = json!(99);
    let told = info(&file, &options(choice("", "", "2"), 0.0)).unwrap();
    let all: Vec<_> = told.animations.iter().map(|a| (a.start, a.end, a.length, a.played)).collect();
    assert_eq!(all, [(0.0, 2.0, 2.0, false), (0.0, 0.0, 0.0, false), (0.0, 4.0, 4.0, true)]);
    assert!(
        told.animations[1].error.as_ref().is_some_and(|e| e.contains("accessor")),
        "{:?}",
        told.animations
    );
    assert!(matches!(info(&moving(), &options(choice("1", "", ""), 0.0)), Err(SceneError::Choice { .. })));
}

#[test]
fn info_counts_what_is_placed_and_what_is_stored() {
    let mut file = squares();
    let places = file.floats(&[[0.0, 0.0, 0.0_f32]; 7]);
    file.json["nodes"][2]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}});
    file.json["nodes"][2]["name"] = json!("crowd");
    file.set("scenes", json!([{"nodes": [0, 2]}, {"nodes": []}]));
    let told = info(&file, &gltf::Options::default()).unwrap();
    let scene = load(&file, gltf::Choice::default(), 0.0);
    assert_eq!(told.counts.triangles, scene.survey.triangles as u64);
    assert_eq!((told.counts.triangles, told.counts.stored_triangles, told.counts.instances), (16, 2, 8));
    let objects: Vec<_> = told.objects.iter().map(|o| (o.name.as_str(), o.instances)).collect();
    assert_eq!(objects, [("mesh 0", 1), ("crowd", 7)]);
    assert!(told.objects.iter().all(|o| scene.objects.iter().any(|object| *object.name == *o.name)));
    let told = info(&file, &options(choice("1", "", ""), 0.0)).unwrap();
    assert_eq!((told.counts.triangles, told.objects.len()), (0, 0));
    // A small file that declares 2^64 triangles is counted, not placed.
    file.json["accessors"][places]["count"] = json!(u64::MAX / 2);
    file.json["accessors"][1]["count"] = json!(u64::MAX / 2);
    if let Ok(told) = info(&file, &gltf::Options::default()) {
        assert!(told.counts.triangles >= 1 << 60);
    }
}

#[test]
fn info_says_where_cameras_stand_and_how_bright_lights_are() {
    let mut file = squares();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let lights = json!([{"type": "point", "name": "lamp", "intensity": 54351.4, "range": 3},
                        {"type": "directional", "intensity": 2.5, "color": [1, 0.5, 0]},
                        {"type": "spot", "intensity": 1, "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}}]);
    file.set("extensions", json!({"KHR_lights_punctual": {"lights": lights}}));
    file.set(
        "cameras",
        json!([{"type": "perspective", "perspective": {"yfov": 1.0, "aspectRatio": 1.5, "znear": 0.25}},
               {"type": "orthographic", "orthographic": {"xmag": -2, "ymag": 1.5, "znear": 0.5, "zfar": 30}}]),
    );
    let lamp = json!({"KHR_lights_punctual": {"light": 0}});
    file.set(
        "nodes",
        json!([{"name": "dolly", "translation": [1, 2, 3], "children": [1, 2]},
               {"name": "eye", "camera": 0, "translation": [0, 0, 4], "scale": [2, 2, 2]},
               // Rotated by 90° about y: looks along −x.
               {"camera": 1, "rotation": [0, half, 0, half], "extensions": lamp},
               {"extensions": lamp}]),
    );
    file.set("scenes", json!([{"nodes": [0, 3]}]));
    let told = info(&file, &gltf::Options::default()).unwrap();
    let [eye, side] = &told.cameras[..] else { panic!("{:?}", told.cameras) };
    assert_eq!((eye.name.as_str(), eye.kind, eye.position), ("eye", "perspective", [1.0, 2.0, 7.0]));
    assert_eq!((eye.direction, eye.up), (Some([0.0, 0.0, -1.0]), Some([0.0, 1.0, 0.0])));
    assert!((eye.yfov_degrees.unwrap() - 1.0_f64.to_degrees()).abs() < 1e-9);
    assert_eq!((eye.znear, eye.zfar, eye.size, eye.aspect), (0.25, None, None, Some(1.5)));
    assert_eq!((side.name.as_str(), side.kind), ("camera 1", "orthographic"));
    assert!((DVec3::from_array(side.direction.unwrap()) - DVec3::NEG_X).length() < 1e-6);
    assert_eq!((side.size, side.zfar, side.yfov_degrees), (Some([4.0, 3.0]), Some(30.0), None));
    let lights: Vec<_> = told.lights.iter().map(|l| (l.kind, l.intensity as f32, l.unit, l.placed)).collect();
    assert_eq!(lights, [("point", 54351.4, "cd", 2), ("directional", 2.5, "lx", 0), ("spot", 1.0, "cd", 0)]);
    assert_eq!((told.lights[0].range, told.lights[1].color), (Some(3.0), [1.0, 0.5, 0.0]));
    let cone = told.lights[2].cone_degrees.unwrap();
    assert!((cone[0] - 0.25_f64.to_degrees()).abs() < 1e-6 && (cone[1] - 0.5_f64.to_degrees()).abs() < 1e-6);
}

#[test]
fn info_lists_skins_morphs_and_what_glows() {
    let mut file = squares();
    file.set("skins", json!([{"name": "rig", "joints": [1, 2]}, {"joints": [1]}]));
    file.json["nodes"][0]["skin"] = json!(0);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}, {"POSITION": 0}]);
    file.json["meshes"][0]["weights"] = json!([0.5, 0]);
    file.json["meshes"][0]["extras"] = json!({"targetNames": ["smile", "frown"]});
    let strength = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 8}});
    file.set("materials", json!([{}, {"emissiveFactor": [0.5, 1, 0], "extensions": strength}]));
    let told = info(&file, &gltf::Options::default()).unwrap();
    let skins: Vec<_> = told.skins.iter().map(|s| (s.name.as_deref(), s.joints, s.placed)).collect();
    assert_eq!(skins, [(Some("rig"), 2, 1), (None, 1, 0)]);
    let [morph] = &told.morphs[..] else { panic!("{:?}", told.morphs) };
    assert_eq!(
        (morph.targets, &morph.weights[..], morph.names.join(" ")),
        (2, &[0.5, 0.0][..], "smile frown".into())
    );
    let [glows] = &told.emissive[..] else { panic!("{:?}", told.emissive) };
    assert_eq!(
        (glows.name.as_str(), Vec3::from_array(glows.radiance)),
        ("material 1", Vec3::new(4.0, 8.0, 0.0))
    );
}

/// Bounds of the selected scene, in the units of the file.
#[test]
fn scenes_know_their_bounds() {
    let scene = load(&scenes(&["", "", "", ""]), choice("3", "", ""), 0.0);
    assert_eq!(scene.bounds, Some((DVec3::new(3.0, 0.0, 0.0), DVec3::new(4.0, 1.0, 0.0))));
    let mut empty = squares();
    empty.set("scenes", json!([{"nodes": []}]));
    assert_eq!(load(&empty, gltf::Choice::default(), 0.0).bounds, None);
}
