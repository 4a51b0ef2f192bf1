//! Command lines without a command; the selection of scenes, variants and animations; and the facts printed by `info`.

mod dapple;

use dapple::{Run, files, run, triangle, well};
use dapple_imaging::read;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

const SMALL: [&str; 6] = ["--size", "12x8", "--spp", "4", "--exposure", "0"];

fn folder_with(name: &str, scene: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), scene).unwrap();
    folder
}

/// Expects a run to fail with one line that contains each of `about`.
fn complains(folder: &Path, arguments: &[&str], about: &[&str]) {
    let Run { code, err, .. } = run(folder, arguments);
    assert_eq!((code, err.lines().count()), (2, 1), "{arguments:?}: {err}");
    assert!(about.iter().all(|what| err.contains(what)), "{arguments:?}: {err}");
}

/// Unlit colours of the triangle: its own, and those of two variants; a second scene without it; two animations that
/// move it out of the image, to the right from second 0 and upwards from second 2.
fn choices() -> String {
    triangle(|root, bytes| {
        let unlit = |color: [f32; 4]| json!({"pbrMetallicRoughness": {"baseColorFactor": color}, "extensions": {"KHR_materials_unlit": {}}});
        root["materials"] =
            json!([unlit([1., 0., 0., 1.]), unlit([0., 1., 0., 1.]), unlit([0., 0., 1., 1.])]);
        root["meshes"][0]["primitives"][0]["material"] = json!(0);
        let mappings = json!([{"material": 1, "variants": [0]}, {"material": 2, "variants": [1]}]);
        root["meshes"][0]["primitives"][0]["extensions"] =
            json!({"KHR_materials_variants": {"mappings": mappings}});
        root["extensions"] =
            json!({"KHR_materials_variants": {"variants": [{"name": "green"}, {"name": "blue"}]}});
        root["scenes"] = json!([{"nodes": [0, 1], "name": "full"}, {"nodes": [1], "name": "empty"}]);
        let mut accessor = |numbers: &[f32], kind: &str, count: usize| {
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            let view = json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * numbers.len()});
            bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
            root["buffers"][0]["byteLength"] = json!(bytes.len());
            let (views, accessors) =
                (root["bufferViews"].as_array().unwrap().len(), root["accessors"].as_array().unwrap().len());
            root["bufferViews"].as_array_mut().unwrap().push(view);
            root["accessors"]
                .as_array_mut()
                .unwrap()
                .push(json!({"bufferView": views, "componentType": 5126, "count": count, "type": kind}));
            accessors
        };
        let (from_0, from_2) = (accessor(&[0., 1.], "SCALAR", 2), accessor(&[2., 3.5], "SCALAR", 2));
        let right = accessor(&[0., 0., 0., 99., 0., 0.], "VEC3", 2);
        let up = accessor(&[0., 0., 0., 0., 99., 0.], "VEC3", 2);
        let moves = |input: usize, output: usize| {
            json!({"samplers": [{"input": input, "output": output}],
                   "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]})
        };
        let (mut first, mut second) = (moves(from_0, right), moves(from_2, up));
        (first["name"], second["name"]) = (json!("right"), json!("up"));
        root["animations"] = json!([first, second]);
    })
}

/// Returns the brightest channel of a render, or "nothing".
fn shown(folder: &Path, more: &[&str]) -> &'static str {
    let always = ["render", "a.gltf", "-o", "a.exr", "--quiet", "--env", "none"];
    let err = well(folder, &[&always[..], &SMALL[..4], more].concat()).err;
    assert!(!err.contains("note: "), "{err}");
    let mean = read::picture(&folder.join("a.exr")).unwrap().mean().to_array();
    let brightest = (0..3).max_by(|a, b| mean[*a].total_cmp(&mean[*b])).unwrap();
    if mean[brightest] == 0.0 { "nothing" } else { ["red", "green", "blue"][brightest] }
}

#[test]
fn scenes_variants_and_animations_are_chosen() {
    let folder = folder_with("a.gltf", &choices());
    for (options, what) in [
        ("", "red"),
        ("--scene full", "red"),
        ("--scene 1", "nothing"),
        ("--variant green", "green"),
        ("--variant 1", "blue"),
        ("--at 1", "nothing"),
        ("--animation up --at 1", "red"),
        ("--animation 1 --at 3.5", "nothing"),
        ("--animation all --at 1", "nothing"),
        ("--animation right --at 0 --variant=0", "green"),
    ] {
        assert_eq!(shown(folder.path(), &options.split_whitespace().collect::<Vec<_>>()), what, "{options}");
    }
    for (option, lists) in [
        ("--scene=2", "0 'full', 1 'empty'"),
        ("--variant=red", "0 'green', 1 'blue'"),
        ("--animation=left", "0 'right', 1 'up'"),
    ] {
        for command in ["render", "info", "plan", "rays"] {
            let (key, value) = option[2..].split_once('=').unwrap();
            complains(folder.path(), &[command, "a.gltf", option], &["a.gltf: ", key, value, lists]);
        }
        complains(folder.path(), &["render", "builtin:cornell", option], &[&option[..7], "builtin:cornell"]);
    }
    // A file beside the scene may select, and the command line takes precedence.
    fs::write(folder.path().join("a.toml"), "variant = 'blue'\nanimation = 1\nat = 1\n").unwrap();
    assert_eq!(shown(folder.path(), &[]), "blue");
    assert_eq!(shown(folder.path(), &["--variant", "green"]), "green");
}

#[test]
fn what_was_not_chosen_is_said_in_one_line_each() {
    let folder = folder_with("a.gltf", &choices());
    let arguments = [&["render", "a.gltf"], &SMALL[..]].concat();
    let notes = |more: &[&str]| {
        let err = well(folder.path(), &[&arguments[..], more].concat()).err;
        err.lines().filter(|line| line.starts_with("note: ")).map(str::to_owned).collect::<Vec<_>>()
    };
    let said = notes(&[]);
    let wanted = ["scene 0 'full' is shown; the file also has 1 'empty'", "0 'green', 1 'blue'", "1 'up'"];
    assert!(said.len() == 3 && said.iter().zip(wanted).all(|(line, what)| line.contains(what)), "{said:?}");
    assert_eq!(notes(&["--scene", "0", "--variant", "0", "--animation", "all"]).len(), 0);
    // The metadata of an EXR reproduces the image.
    let layers = read::layers(&folder.path().join("a.exr")).unwrap();
    let text = format!("{:?}", layers.metadata);
    assert!(text.contains("variant = ") && text.contains("animation = "), "{text}");
}

#[test]
fn a_file_alone_is_rendered() {
    let folder = folder_with("a.gltf", &triangle(|_, _| {}));
    assert_eq!(well(folder.path(), &[&["a.gltf"], &SMALL[..]].concat()).out, "a.exr\na.png\n");
    let path = folder.path().join("a.gltf");
    let more = ["-o", "b.png", "--json"];
    let json = well(folder.path(), &[&[path.to_str().unwrap()], &SMALL[..], &more].concat()).json();
    assert_eq!((&json["outputs"], &json["width"]), (&json!(["b.png"]), &json!(12)));
    assert_eq!(
        well(folder.path(), &[&["builtin:furnace", "-o", "c.exr"], &SMALL[..]].concat()).out,
        "c.exr\n"
    );
    // Files without an extension, and files named like a command.
    for name in ["scene", "info"] {
        fs::copy(&path, folder.path().join(name)).unwrap();
    }
    assert_eq!(well(folder.path(), &[&["scene", "-o", "d.exr"], &SMALL[..]].concat()).out, "d.exr\n");
    assert_eq!(well(folder.path(), &[&["./info", "-o", "e.exr"], &SMALL[..]].concat()).out, "e.exr\n");
    assert!(
        well(folder.path(), &["info", "info"]).out.starts_with("info: "),
        "a command takes precedence over a file"
    );
    assert_eq!(run(folder.path(), &["info"]).code, 2);
    complains(folder.path(), &["missing.glb"], &["missing.glb: cannot read"]);
    complains(folder.path(), &["rendr"], &["rendr", "render"]);
    assert!(well(folder.path(), &["a.gltf", "--help"]).out.contains("--spp"));
}

#[test]
fn nothing_at_all_is_greeted() {
    let folder = tempfile::tempdir().unwrap();
    let Run { out, err, .. } = well(folder.path(), &[]);
    assert!(
        out.contains("Usage:") && out.trim_end().lines().last().unwrap().contains("dapple render"),
        "{out}"
    );
    assert_eq!((err.as_str(), files(folder.path()).len()), ("", 0));
}

fn info(folder: &Path, more: &[&str]) -> Value {
    well(folder, &[&["info", "a.gltf", "--json"], more].concat()).json()
}

#[test]
fn info_lists_what_can_be_chosen() {
    let folder = folder_with("a.gltf", &choices());
    let facts = info(folder.path(), &["--variant", "blue", "--animation", "up", "--at", "2"]);
    let names =
        |key: &str| facts[key].as_array().unwrap().iter().map(|x| x["name"].clone()).collect::<Vec<_>>();
    assert_eq!(names("scenes"), ["full", "empty"]);
    assert_eq!(names("variants"), ["green", "blue"]);
    assert_eq!(names("animations"), ["right", "up"]);
    assert_eq!(names("objects"), ["triangle"]);
    assert_eq!(
        (&facts["scenes"][0]["default"], &facts["variants"][1]["shown"]),
        (&json!(true), &json!(true))
    );
    assert_eq!(
        (&facts["animations"][1]["length"], &facts["animations"][1]["end"]),
        (&json!(1.5), &json!(3.5))
    );
    assert_eq!(facts["bounds"], json!({"min": [-1.0, -1.0, 0.0], "max": [1.0, 1.0, 0.0]}));
    let camera = &facts["cameras"][0];
    assert_eq!(camera["position"], json!([0.0, 0.0, 4.0]));
    assert_eq!(camera["direction"], json!([0.0, 0.0, -1.0]));
    assert_eq!((&camera["kind"], &camera["zfar"]), (&json!("perspective"), &Value::Null));
    let text = well(folder.path(), &["info", "a.gltf"]).out;
    for line in [
        "  0 'full': 2 root nodes (the default, shown)",
        "  1 'empty': 1 root node",
        "  1 'blue': 1 primitives",
        "  1 'up': 2.000 s to 3.500 s, 1.500 s long, 1 channels",
        "bounds: (-1, -1, 0) to (1, 1, 0)",
        "objects (1): triangle",
        "  'eye': perspective at (0, 0, 4) towards (0, 0, -1), 45.8366 degrees high, aspect ratio 2, znear 0.1, zfar infinite",
    ] {
        assert!(text.lines().any(|l| l == line), "{line}\n{text}");
    }
    assert!(text.contains("note: scene 0 'full' is shown"), "{text}");
    // For a scene without a camera, the position of the framing camera is reported.
    let bare = folder_with("a.gltf", &triangle(|root, _| root["scenes"] = json!([{"nodes": [0]}])));
    let facts = info(bare.path(), &[]);
    assert_eq!(facts["cameras"][0]["name"], "auto");
    assert!(facts["cameras"][0]["position"][2].as_f64().unwrap() > 1.0);
}

/// The warnings of `info` are those of `render`, from every stage.
#[test]
fn info_warns_as_a_render_does() {
    let scenes = [
        choices(),
        triangle(|_, _| {}),
        // A black emitter, an unsupported extension, an unlikely index of refraction, a shared root.
        triangle(|root, _| {
            root["materials"] = json!([{"emissiveFactor": [0, 0, 0], "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1},
                "KHR_materials_ior": {"ior": 0.5}}}]);
            root["meshes"][0]["primitives"][0]["material"] = json!(0);
            root["nodes"][1]["children"] = json!([0]);
        }),
        // Degenerate triangles, a missing texture, morph targets and lines.
        triangle(|root, _| {
            root["images"] = json!([{"uri": "missing.png"}]);
            root["textures"] = json!([{"source": 0}]);
            root["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
            let mut primitive = root["meshes"][0]["primitives"][0].clone();
            primitive["material"] = json!(0);
            primitive["targets"] = json!([{"POSITION": 0}]);
            let mut lines = primitive.clone();
            lines["mode"] = json!(1);
            root["meshes"][0]["primitives"] = json!([primitive, lines]);
            root["meshes"][0]["weights"] = json!([1]);
            root["nodes"][0]["scale"] = json!([1, 0, 0]);
        }),
        // Two coincident lamps; a light too weak to be visible.
        triangle(|root, _| {
            root["materials"] = json!([{"emissiveFactor": [1, 1, 1]}]);
            root["meshes"][0]["primitives"][0]["material"] = json!(0);
            root["nodes"].as_array_mut().unwrap().push(json!({"mesh": 0}));
            root["scenes"][0]["nodes"] = json!([0, 1, 2]);
        }),
        triangle(|root, _| {
            root["materials"] = json!([{}, {"emissiveFactor": [1, 1, 1]}]);
            let mut lamp = root["meshes"][0].clone();
            lamp["primitives"][0]["material"] = json!(1);
            root["meshes"].as_array_mut().unwrap().push(lamp);
            let lamp = json!({"mesh": 1, "translation": [0.2, 0.3, 0.5], "scale": [0.02, 0.02, 0.02]});
            root["nodes"].as_array_mut().unwrap().push(lamp);
            root["scenes"][0]["nodes"] = json!([0, 1, 2]);
        }),
    ];
    let mut different = std::collections::BTreeSet::new();
    for scene in scenes {
        let folder = folder_with("a.gltf", &scene);
        for more in [&[][..], &["--env", "none"]] {
            let rendered = well(folder.path(), &[&["render", "a.gltf", "--json"], &SMALL[..], more].concat());
            let (facts, rendered) = (info(folder.path(), more), rendered.json());
            assert_eq!(facts["warnings"], rendered["warnings"], "{scene}");
            different.extend(facts["warnings"].as_array().unwrap().iter().map(Value::to_string));
        }
    }
    assert!(different.len() >= 9, "the scenes give {} different warnings: {different:?}", different.len());
}

/// If `render` would reject a scene, the reason is printed together with the available facts.
#[test]
fn info_says_what_a_render_would_refuse() {
    let folder = folder_with(
        "a.gltf",
        &triangle(|root, _| {
            root["extensionsRequired"] = json!(["VENDOR_magic"]);
            root["extensions"] = json!({"VENDOR_magic": {}});
        }),
    );
    let facts = info(folder.path(), &[]);
    assert!(facts["error"].as_str().unwrap().contains("VENDOR_magic") && facts["triangles"] == 1, "{facts}");
    assert!(
        well(folder.path(), &["info", "a.gltf"])
            .out
            .contains("error: a render would reject this: a.gltf: needs")
    );
    let folder =
        folder_with("a.gltf", &triangle(|root, _| root["meshes"][0]["primitives"][0]["indices"] = json!(0)));
    let refused = run(folder.path(), &["render", "a.gltf"]);
    assert_eq!(refused.code, 2);
    let error = info(folder.path(), &[])["error"].as_str().unwrap().to_owned();
    assert_eq!(refused.err.trim_end(), format!("error: {error}"));
    // The same holds for an invalid settings file beside it; one with forbidden keys gives a warning.
    let folder = folder_with("a.gltf", &triangle(|_, _| {}));
    fs::write(folder.path().join("a.toml"), "sppp = ").unwrap();
    assert!(info(folder.path(), &[])["error"].as_str().unwrap().contains("a.toml"));
    fs::write(folder.path().join("a.toml"), "output = ['b.exr']\nscene = 0").unwrap();
    let facts = info(folder.path(), &[]);
    assert!(facts["warnings"][0].as_str().unwrap().contains("ignored 'output'"), "{facts}");
    assert_eq!((facts.get("error"), &facts["settings_file"]), (None, &json!("a.toml")));
}

/// Instances: all placed triangles are counted, and the predicted memory is what a render then uses.
#[test]
fn info_foretells_the_memory_of_a_render() {
    let many: Vec<Value> = (0..4000).map(|i| json!({"mesh": 0, "translation": [0, 0, -i]})).collect();
    let folder = folder_with(
        "a.gltf",
        &triangle(|root, _| {
            let nodes = root["nodes"].as_array_mut().unwrap();
            nodes.extend(many);
            root["scenes"][0]["nodes"] = (1..nodes.len()).collect();
        }),
    );
    let size = ["--size", "500x400"];
    let facts = info(folder.path(), &size);
    assert_eq!((&facts["triangles"], &facts["stored_triangles"]), (&json!(4000), &json!(1)));
    let rendered =
        well(folder.path(), &[&["render", "a.gltf", "--spp", "1", "--json"], &size[..]].concat()).json();
    let [told, was] = [&facts, &rendered].map(|json| json["peak_memory_bytes"].as_f64().unwrap());
    if was > 0.0 {
        assert!((told / was - 1.0).abs() < 0.4, "{told} was foretold, {was} it was");
    }
}

#[test]
fn info_of_a_builtin_has_the_same_facts() {
    let folder = folder_with("a.gltf", &triangle(|_, _| {}));
    let (file, builtin) =
        (info(folder.path(), &[]), well(folder.path(), &["info", "builtin:cornell", "--json"]).json());
    for key in file.as_object().unwrap().keys() {
        let only_in_files =
            ["generator", "skins", "morphed", "vertices", "visible_nodes"].contains(&key.as_str());
        assert!(only_in_files || builtin.get(key).is_some(), "{key} is missing: {builtin}");
    }
    assert_eq!(builtin["emissive"][0]["radiance"], json!([17.0, 12.0, 4.0]));
    assert_eq!(builtin["cameras"].as_array().unwrap().len(), 1);
    complains(folder.path(), &["info", "builtin:nothing"], &["builtin:nothing", "cornell"]);
}
