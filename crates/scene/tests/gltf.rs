//! The glTF reader on files written here: every way to store numbers, every way to be wrong.
#![cfg(feature = "gltf")]
mod file;

use dapple_camera::Shutter;
use dapple_scene::{AlphaMode, LightUnit, Reads, Scene, gltf};
use file::{File, json};
use glam::{DVec3, Vec3};
use serde_json::Value;
use std::path::Path;

const OPTIONS: gltf::Options = gltf::Options {
    at: 0.0,
    shutter: Shutter { open: 0.0, close: 0.0 },
    allow_path: false,
    strict: false,
    reads: Reads::EVERYTHING,
    memory: dapple_imaging::MemoryLimit::NONE,
    choice: gltf::Choice { scene: None, variant: None, animation: None },
    light_unit: LightUnit::Auto,
};

fn read(bytes: &[u8]) -> Result<Scene, dapple_scene::SceneError> {
    gltf::read_bytes(Path::new("test.gltf"), bytes, &OPTIONS)?.build()
}

fn load(file: &File) -> Scene {
    read(&file.gltf()).unwrap_or_else(|e| panic!("{e}"))
}

fn error(file: &File) -> String {
    match read(&file.gltf()) {
        Ok(_) => panic!("this should not load"),
        Err(e) => {
            let text = e.to_string();
            assert!(!text.contains('\n') && text.contains("test.gltf"), "{text}");
            text
        }
    }
}

/// World corners of a triangle.
fn corners(scene: &Scene, object: u32, primitive: u32) -> [DVec3; 3] {
    scene.world.corners(object, primitive).map(|p| scene.space.to_world(p))
}

fn assert_near(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-5, "{a} is not {b}");
}

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

/// A square of two triangles, one node, one mesh, one primitive.
fn square() -> File {
    let mut file = File::new();
    let positions = file.floats(&SQUARE);
    let indices = file.indices_u16(&[0, 1, 2, 0, 2, 3]);
    file.set(
        "meshes",
        json!([{"primitives": [{"attributes": {"POSITION": positions}, "indices": indices}]}]),
    );
    file.set("nodes", json!([{"mesh": 0}]));
    file
}

#[test]
fn a_square() {
    let scene = load(&square());
    assert_eq!((scene.survey.triangles, scene.survey.objects), (2, 1));
    let got = corners(&scene, 0, 1);
    for (got, want) in got.into_iter().zip([0, 2, 3]) {
        assert_near(got, Vec3::from_array(SQUARE[want]).as_dvec3());
    }
    assert_eq!(scene.name, "test");
    assert_eq!(&*scene.cameras[0].name, "auto");
    assert!(scene.warnings.iter().any(|w| w.0.contains("studio environment")));
    assert!(scene.environment.is_some());
}

#[test]
fn glb_and_gltf_give_the_same() {
    let file = square();
    let (a, b) = (load(&file), read(&file.glb()).unwrap());
    assert_eq!(a.world.corners(0, 1), b.world.corners(0, 1));
}

#[test]
fn every_component_type_normalised_and_not() {
    let cases: [(u32, &[u8], bool, f64); 12] = [
        (5120, &[127], true, 1.0),
        (5120, &[128], true, -1.0),
        (5120, &[127], false, 127.0),
        (5121, &[255], true, 1.0),
        (5121, &[255], false, 255.0),
        (5122, &[0xff, 0x7f], true, 1.0),
        (5122, &[0, 0x80], true, -1.0),
        (5122, &[0, 0x80], false, -32768.0),
        (5123, &[0xff, 0xff], true, 1.0),
        (5123, &[0xff, 0xff], false, 65535.0),
        (5125, &[7, 0, 0, 0], false, 7.0),
        (5126, &[0, 0, 0xc0, 0x3f], false, 1.5),
    ];
    for (component, bytes, normalized, value) in cases {
        // Triangle (0,0,0), (x,0,0), (0,x,0) with x the value in question; elements padded to 4 bytes.
        let size = bytes.len();
        let zero = vec![0; size];
        let element = |parts: [&[u8]; 3]| {
            let mut out = parts.concat();
            out.resize((3 * size).next_multiple_of(4), 0);
            out
        };
        let data =
            [element([&zero, &zero, &zero]), element([bytes, &zero, &zero]), element([&zero, bytes, &zero])]
                .concat();
        let mut file = square();
        let stride = (3 * size).next_multiple_of(4);
        let view = file.view(&data, Some(stride));
        let positions = file.accessor(json!({
            "bufferView": view, "componentType": component, "normalized": normalized, "count": 3, "type": "VEC3",
        }));
        file.set("meshes", json!([{"primitives": [{"attributes": {"POSITION": positions}}]}]));
        let scene = load(&file);
        let [_, b, c] = corners(&scene, 0, 0);
        assert!((b.x - value).abs() < 1e-5 * value.abs(), "{component} {normalized}: {b}");
        assert!((c.y - value).abs() < 1e-5 * value.abs(), "{component} {normalized}: {c}");
    }
}

#[test]
fn every_index_type() {
    for (component, bytes) in [
        (5121, vec![0_u8, 1, 2]),
        (5123, vec![0, 0, 1, 0, 2, 0]),
        (5125, vec![0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]),
    ] {
        let mut file = square();
        let view = file.view(&bytes, None);
        let indices = file
            .accessor(json!({"bufferView": view, "componentType": component, "count": 3, "type": "SCALAR"}));
        file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        assert_eq!(load(&file).survey.triangles, 1, "{component}");
    }
    let mut signed = square();
    signed.json["accessors"][1]["componentType"] = json!(5122);
    assert!(error(&signed).contains("does not hold indices"));
}

#[test]
fn strips_fans_and_the_rest() {
    for (mode, triangles, second) in [(4, 1, None), (5, 2, Some([1, 3, 2])), (6, 2, Some([2, 3, 0]))] {
        let mut file = square();
        file.json["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": 0}, "mode": mode});
        let scene = load(&file);
        assert_eq!(scene.survey.triangles, triangles, "{mode}");
        if let Some(second) = second {
            let got = corners(&scene, 0, 1);
            for (got, want) in got.into_iter().zip(second) {
                assert_near(got, Vec3::from_array(SQUARE[want as usize]).as_dvec3());
            }
        }
    }
    for mode in [0, 1, 2, 3] {
        let mut file = square();
        file.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let scene = load(&file);
        assert_eq!(scene.survey.triangles, 0);
        assert!(scene.warnings.iter().any(|w| w.0.contains("points and lines")));
    }
    let mut file = square();
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(7);
    assert!(error(&file).contains("mesh 0, primitive 0: has an unknown mode"));
}

#[test]
fn sparse_accessors_with_and_without_a_base() {
    for base in [true, false] {
        let mut file = square();
        let at = file.view(&[2, 3], None);
        let values = file.view(&file::bytes(&[[5.0, 5.0, 0.0], [0.0, 5.0, 0.0]]), None);
        let mut accessor = json!({
            "componentType": 5126, "count": 4, "type": "VEC3",
            "sparse": {
                "count": 2,
                "indices": {"bufferView": at, "componentType": 5121},
                "values": {"bufferView": values},
            },
        });
        if base {
            accessor["bufferView"] = file.json["accessors"][0]["bufferView"].clone();
        }
        file.json["accessors"][0] = accessor;
        let scene = load(&file);
        let [_, corner, _] = corners(&scene, 0, if base { 1 } else { 0 });
        assert_near(corner, DVec3::new(5.0, 5.0, 0.0));
        assert_eq!(
            scene.survey.triangles,
            if base { 2 } else { 1 },
            "without base corner 1 is at 0: no area"
        );
    }
    let mut file = square();
    let at = file.view(&[9], None);
    let values = file.view(&[0; 12], None);
    file.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": values},
    });
    assert!(error(&file).contains("sparse index Some(9)"));
    file.json["accessors"][0]["sparse"]["count"] = json!(u64::MAX);
    assert!(error(&file).contains("end early"));
}

#[test]
fn hierarchies_compose() {
    let mut file = square();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    file.set(
        "nodes",
        json!([
            {"children": [1], "translation": [10, 0, 0]},
            {"children": [2], "rotation": [0, 0, half, half]},
            {"mesh": 0, "matrix": [2,0,0,0, 0,2,0,0, 0,0,2,0, 1,0,0,1]},
        ]),
    );
    let scene = load(&file);
    // (1,0,0) → ×2 +1 → (3,0,0) → turned by 90° about z → (0,3,0) → moved.
    assert_near(corners(&scene, 0, 0)[1], DVec3::new(10.0, 3.0, 0.0));
}

#[test]
fn far_translations_change_no_bit() {
    let at = |t: f64| {
        let mut file = square();
        file.set(
            "nodes",
            json!([
                {"children": [1], "translation": [t, t, t]},
                {"mesh": 0, "translation": [0.1, 0.7, -0.3], "rotation": [0.18, 0.36, 0.54, 0.74], "scale": [1, 2, 3]},
            ]),
        );
        let scene = load(&file);
        [scene.world.corners(0, 0), scene.world.corners(0, 1)]
    };
    for t in [1e3, 1e5, 1e6, 1e7] {
        assert_eq!(at(0.0), at(t), "{t}");
    }
}

#[test]
fn mirrors_keep_the_front() {
    for scale in [[1, 1, 1], [-1, 1, 1], [-1, -1, 1], [-1, -1, -1], [1, 1, -1]] {
        let mut file = square();
        file.json["nodes"][0]["scale"] = json!(scale);
        let scene = load(&file);
        let [a, b, c] = corners(&scene, 0, 0);
        let front = (b - a).cross(c - a).normalize();
        assert_near(front, DVec3::Z * f64::from(scale[2]));
    }
}

#[test]
fn instances() {
    let mut file = square();
    let translations = file.floats(&[[0.0, 0.0, 0.0], [0.0, 0.0, 5.0], [0.0, 0.0, 9.0]]);
    file.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translations}}});
    file.set("extensionsRequired", json!(["EXT_mesh_gpu_instancing"]));
    let scene = load(&file);
    assert_eq!(scene.survey.objects, 3);
    assert_near(corners(&scene, 2, 0)[1], DVec3::new(1.0, 0.0, 9.0));
}

#[test]
fn animation_at_a_time() {
    let mut file = square();
    let times = file.scalars(&[1.0, 3.0]);
    let places = file.floats(&[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
    file.set(
        "animations",
        json!([{
            "samplers": [{"input": times, "output": places}],
            "channels": [
                {"sampler": 0, "target": {"node": 0, "path": "translation"}},
                {"sampler": 0, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {}}}},
            ],
        }]),
    );
    for (time, x) in [(0.0, 0.0), (1.0, 0.0), (2.0, 2.0), (3.0, 4.0), (9.0, 4.0)] {
        let options = gltf::Options { at: time, ..OPTIONS };
        let builder = gltf::read_bytes(Path::new("test.gltf"), &file.gltf(), &options).unwrap();
        assert_near(corners(&builder.build().unwrap(), 0, 0)[0], DVec3::new(x, 0.0, 0.0));
    }
    file.json["accessors"][times]["count"] = json!(1);
    assert!(error(&file).contains("animation 0: has 1 keys and 2 values"));
}

#[test]
fn required_extensions_are_named() {
    let mut file = square();
    file.set("extensionsRequired", json!(["KHR_materials_ior", "VENDOR_magic"]));
    file.json["nodes"][0]["extensions"] = json!({"VENDOR_magic": {}, "KHR_materials_ior": {}});
    let text = error(&file);
    assert!(text.contains("VENDOR_magic") && !text.contains("ior"), "{text}");
    file.set("extensionsRequired", json!([]));
    file.set("extensionsUsed", json!(["KHR_materials_clearcoat", "KHR_xmp_json_ld"]));
    file.json["nodes"][0]["extensions"] = json!({"KHR_materials_clearcoat": {}, "KHR_xmp_json_ld": {}});
    let scene = load(&file);
    assert!(scene.warnings.iter().any(|w| w.0.contains("clear coats are left out")));
    assert!(!scene.warnings.iter().any(|w| w.0.contains("xmp")));
}

#[test]
fn every_truncation_of_a_glb_is_one_error() {
    let whole = file::showcase().glb();
    assert!(read(&whole).is_ok());
    for n in 0..whole.len() {
        match read(&whole[..n]) {
            Ok(_) => panic!("{n} of {} bytes load", whole.len()),
            Err(e) => assert!(e.to_string().starts_with("test.gltf"), "{e}"),
        }
    }
}

/// Changes one place of the showcase at a time; the message must name that place.
#[test]
fn indices_out_of_range_are_named() {
    let cases = [
        ("/nodes/0/mesh", json!(7), "mesh 7"),
        ("/nodes/1/camera", json!(7), "camera 7"),
        ("/nodes/0/children", json!([99]), "node 99"),
        ("/scenes/0/nodes", json!([99]), "node 99"),
        ("/scene", json!(3), "scene 3"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(99), "accessor 99"),
        ("/meshes/0/primitives/0/attributes/NORMAL", json!(99), "accessor 99"),
        ("/meshes/0/primitives/0/indices", json!(99), "accessor 99"),
        ("/meshes/0/primitives/0/material", json!(99), "material 99"),
        ("/accessors/0/bufferView", json!(99), "buffer view 99"),
        ("/accessors/0/byteOffset", json!(40), "ends early"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "ends early"),
        ("/accessors/0/count", json!(5), "ends early"),
        ("/accessors/0/count", json!(u32::MAX), "ends early"),
        ("/accessors/0/count", json!(u64::MAX), "at most"),
        ("/accessors/0/type", json!("VEC5"), "unknown type"),
        ("/accessors/0/type", json!("MAT4"), "matrices"),
        ("/accessors/0/type", json!("VEC2"), "2 components where 3"),
        ("/accessors/0/componentType", json!(5124), "unknown type"),
        ("/bufferViews/0/buffer", json!(99), "buffer 99"),
        ("/bufferViews/0/byteOffset", json!(1_000_000), "ends at byte"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "ends at byte"),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "ends at byte"),
        ("/bufferViews/0/byteStride", json!(4), "stride of 4"),
        ("/bufferViews/0/byteStride", json!(u64::MAX), "ends early"),
        ("/buffers/0/byteLength", json!(1_000_000), "of its 1000000 bytes"),
        ("/textures/0/source", json!(99), "image 99"),
        ("/textures/0/sampler", json!(99), "sampler 99"),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", json!(99), "texture 99"),
        ("/materials/0/normalTexture/index", json!(99), "texture 99"),
        ("/animations/0/channels/0/target/node", json!(99), "node 99"),
        ("/animations/0/channels/0/sampler", json!(99), "sampler 99"),
        ("/animations/0/samplers/0/input", json!(99), "accessor 99"),
        ("/nodes/2/extensions/KHR_lights_punctual/light", json!(99), "light 99"),
        ("/images/0/bufferView", json!(99), "buffer view 99"),
        ("/nodes/0/rotation", json!([0, 0, 0, 0]), "rotation is zero"),
        ("/nodes/0/scale", json!([1, 1]), "invalid length 2"),
        ("/nodes/0/translation", json!([1, "a", 1]), "test.gltf"),
        ("/cameras/0/perspective/yfov", json!(4.0), "yfov"),
        ("/materials/0/emissiveFactor", json!([1, -1, 1]), "emission must be"),
        ("/asset/version", json!("1.0"), "glTF 1.0"),
    ];
    for (pointer, value, expected) in cases {
        let mut file = file::showcase();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        file.json.pointer_mut(parent).unwrap_or_else(|| panic!("{pointer}"))[key] = value.clone();
        let text = error(&file);
        assert!(text.contains(expected), "{pointer} = {value}: {text}");
    }
}

#[test]
fn positions_that_are_no_places_are_named() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut file = square();
        let mut positions = SQUARE;
        positions[2][1] = bad;
        let index = file.floats(&positions);
        file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(index);
        file.json["meshes"][0]["name"] = json!("broken");
        let text = error(&file);
        assert!(text.contains("mesh 0 'broken', primitive 0: vertex 2"), "{text}");
    }
    let mut far = square();
    far.json["nodes"][0]["translation"] = json!([1e307, 0, 0]);
    far.json["nodes"][0]["scale"] = json!([1e307, 1e307, 1e307]);
    assert!(error(&far).contains("object 0"));
}

#[test]
fn indices_beyond_the_vertices_are_named() {
    let mut file = square();
    let indices = file.indices_u16(&[0, 1, 4]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert!(error(&file).contains("triangle 0 has corners 0, 1, 4, but there are 4 vertices"));
}

#[test]
fn the_node_graph_is_a_forest() {
    let with_nodes = |nodes: Value, roots: Value| {
        let mut file = square();
        file.set("nodes", nodes);
        file.set("scenes", json!([{"nodes": roots}]));
        file
    };
    let cycle = with_nodes(json!([{"children": [1]}, {"children": [0]}]), json!([0]));
    assert!(error(&cycle).contains("node 0: is in the scene twice"));
    let own = with_nodes(json!([{"children": [0]}]), json!([0]));
    assert!(error(&own).contains("node 0"));
    let parents = with_nodes(json!([{"children": [2]}, {"children": [2]}, {"mesh": 0}]), json!([0, 1]));
    assert!(error(&parents).contains("node 2: is a child of node 0 and of node 1"));
    // Seen once each: below the parent where that is in the scene, else as the root it is said to be.
    for (roots, said) in [(json!([0, 1]), "as the child"), (json!([0]), "as the root")] {
        let scene = load(&with_nodes(json!([{"mesh": 0}, {"children": [0], "mesh": 0}]), roots));
        assert_eq!(scene.survey.objects, if said == "as the child" { 2 } else { 1 });
        assert!(scene.warnings.iter().any(|w| w.0.contains("node 0") && w.0.contains(said)), "{said}");
    }
    let twice = with_nodes(json!([{"mesh": 0}]), json!([0, 0]));
    assert!(error(&twice).contains("node 0: is in the scene twice"));
    // Deep, but a chain: no recursion to overflow.
    let n = 100_000;
    let mut nodes: Vec<Value> = (0..n).map(|i| json!({"children": [i + 1]})).collect();
    nodes.push(json!({"mesh": 0}));
    assert_eq!(load(&with_nodes(json!(nodes), json!([0]))).survey.objects, 1);
}

#[test]
fn a_scene_may_show_nothing() {
    let mut file = square();
    file.set("scenes", json!([{"name": "empty"}]));
    assert_eq!(load(&file).survey.objects, 0);
}

#[test]
fn a_required_extension_that_nothing_uses_is_no_hindrance() {
    let mut file = square();
    file.set("extensionsRequired", json!(["VENDOR_magic"]));
    assert!(
        load(&file)
            .warnings
            .iter()
            .any(|w| w.0.contains("VENDOR_magic") && w.0.contains("nothing in the file"))
    );
    file.json["nodes"][0]["extensions"] = json!({"VENDOR_magic": {}});
    assert!(error(&file).contains("VENDOR_magic"));
}

/// What a file uses is warned of, declared or not; what it only declares is not.
#[test]
fn extensions_are_known_by_their_use() {
    let mut file = square();
    file.set("extensionsUsed", json!(["KHR_materials_sheen"]));
    file.set("materials", json!([{"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}}]));
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let said = |word: &str| load(&file).warnings.iter().any(|w| w.0.contains(word));
    assert!(said("KHR_materials_clearcoat") && !said("sheen"));
}

#[test]
fn images_are_found_by_the_names_of_other_systems_or_left_out() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("textures")).unwrap();
    std::fs::write(dir.path().join("textures/a b.png"), RED_PNG).unwrap();
    let path = dir.path().join("scene.gltf");
    let try_uri = |uri: &str, strict: bool| {
        let mut file = square();
        file.set("images", json!([{"uri": uri}]));
        file.set("textures", json!([{"source": 0}]));
        let texture = json!({"index": 0});
        file.set("materials", json!([{
            "pbrMetallicRoughness": {"baseColorTexture": texture, "baseColorFactor": [0.25, 0.5, 0.75, 1.0]},
            "emissiveTexture": texture, "emissiveFactor": [1.0, 1.0, 1.0],
        }]));
        file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        std::fs::write(&path, file.gltf()).unwrap();
        gltf::read(&path, &gltf::Options { strict, ..OPTIONS }).and_then(|b| b.build())
    };
    let found = try_uri("textures/a b.png", true).unwrap();
    let renamed = |scene: &Scene| scene.warnings.iter().any(|w| w.0.contains("was found as"));
    assert!(!renamed(&found), "{:?}", found.warnings);
    for uri in ["textures\\a b.png", "Textures/A%20b.PNG", "TEXTURES\\A b.png"] {
        let other = try_uri(uri, true).unwrap_or_else(|e| panic!("{uri}: {e}"));
        assert!(renamed(&other), "{uri}");
        assert_eq!(other.materials[0].base, found.materials[0].base);
    }
    // Not there: the factor remains, and nothing glows that a texture was to hold down.
    let missing = try_uri("not_there.png", false).unwrap();
    assert!(missing.warnings.iter().any(|w| w.0.contains("not_there.png")));
    assert_eq!(missing.materials[0].base.base_color, Vec3::new(0.25, 0.5, 0.75));
    assert_eq!((missing.materials[0].emission, missing.materials[0].base_color_texture), (Vec3::ZERO, None));
    assert!(try_uri("not_there.png", true).unwrap_err().to_string().contains("not_there.png"));
    assert!(try_uri("..\\secret.png", true).is_err());
}

/// One red pixel.
const RED_PNG: &[u8] = &[
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 1, 0, 0, 0, 1, 8, 2, 0, 0, 0, 144,
    119, 83, 222, 0, 0, 0, 12, 73, 68, 65, 84, 120, 156, 99, 248, 207, 192, 0, 0, 3, 1, 1, 0, 201, 254, 146,
    239, 0, 0, 0, 0, 73, 69, 78, 68, 174, 66, 96, 130,
];

#[test]
fn hidden_nodes_hide_their_children() {
    let mut file = square();
    file.set(
        "nodes",
        json!([
            {"mesh": 0},
            {"children": [2], "extensions": {"KHR_node_visibility": {"visible": false}}},
            {"mesh": 0},
        ]),
    );
    file.set("scenes", json!([{"nodes": [0, 1]}]));
    assert_eq!(load(&file).survey.objects, 1);
}

#[test]
fn files_stay_in_their_folder() {
    let dir = tempfile::tempdir().unwrap();
    let scene_dir = dir.path().join("scene");
    std::fs::create_dir_all(scene_dir.join("data")).unwrap();
    let file = square();
    let data = file.buffer();
    std::fs::write(dir.path().join("outside.bin"), &data).unwrap();
    std::fs::write(scene_dir.join("data/with space.bin"), &data).unwrap();
    std::fs::write(scene_dir.join("short.bin"), &data[..10]).unwrap();
    let outside = dir.path().join("outside.bin").to_str().unwrap().to_owned();
    let path = scene_dir.join("scene.gltf");
    let try_uri = |uri: &str, allow_path: bool| {
        let mut file = square();
        file.uri = Some(uri.to_owned());
        std::fs::write(&path, file.gltf()).unwrap();
        gltf::read(&path, &gltf::Options { allow_path, ..OPTIONS }).and_then(|b| b.build())
    };
    assert!(try_uri("data/with%20space.bin", false).is_ok());
    assert!(try_uri("data/../data/with space.bin", false).is_ok());
    for (uri, expected) in [
        ("../outside.bin", "outside the scene's folder"),
        ("%2e%2e/outside.bin", "outside the scene's folder"),
        (&*outside, "outside the scene's folder"),
        ("https://example.org/a.bin", "only files and data URIs"),
        ("data", "it is not a file"),
        ("missing.bin", "cannot read buffer 0 'missing.bin'"),
        ("short.bin", "holds 10 of its"),
    ] {
        let text = try_uri(uri, false).unwrap_err().to_string();
        assert!(text.contains(expected), "{uri}: {text}");
    }
    assert!(try_uri("../outside.bin", true).is_ok());
    assert!(try_uri(&outside, true).is_ok());
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&outside, scene_dir.join("link.bin")).unwrap();
        std::os::unix::fs::symlink(scene_dir.join("data/with space.bin"), scene_dir.join("inner.bin"))
            .unwrap();
        assert!(
            try_uri("link.bin", false).unwrap_err().to_string().contains("link out of the scene's folder")
        );
        assert!(try_uri("link.bin", true).is_ok());
        assert!(try_uri("inner.bin", false).is_ok());
    }
}

#[test]
fn counts_without_data_do_not_fill_memory() {
    let mut file = square();
    file.json["accessors"][0] = json!({"componentType": 5126, "count": 4_000_000_000_u64, "type": "VEC3"});
    assert!(error(&file).contains("without data"));
    // Many modest ones add up.
    file.json["accessors"][0]["count"] = json!(1 << 20);
    let primitive = json!({"attributes": {"POSITION": 0}});
    file.json["meshes"][0]["primitives"] = json!(vec![primitive; 8]);
    assert!(error(&file).contains("without data"));
}

#[test]
fn materials_arrive() {
    let scene = load(&file::showcase());
    let m = &scene.materials[0];
    assert_eq!(m.name, "painted");
    assert_eq!(m.base.base_color, Vec3::new(0.5, 0.25, 1.0));
    assert_eq!((m.base.metallic, m.base.roughness, m.base.ior), (0.25, 0.5, 1.33));
    assert_eq!(m.emission, Vec3::new(2.0, 0.0, 4.0));
    assert_eq!(m.alpha_mode, AlphaMode::Mask { cutoff: 0.75 });
    assert!(m.double_sided && m.normal_texture.is_some());
    assert_eq!(m.base_color_texture.unwrap().uv_set, 1, "the transform's texCoord wins");
    assert_eq!(m.base_color_texture.unwrap().transform.unwrap().translation.to_array(), [0.5, 0.25]);
    // One image as colour and as data: two textures.
    assert_eq!(scene.textures.len(), 2);
    assert!(!m.base.thin && m.base.transmission == 0.5);
    let sigma = f64::from(m.sigma_a.x) * scene.space.scale;
    assert!((sigma - f64::ln(2.0) / 3.0).abs() < 1e-6);
    let mirror = scene.materials[1].base.mirror.unwrap();
    assert_eq!((mirror.kr, mirror.blur), (Vec3::new(0.9, 0.8, 0.7), 0.125));
}

#[test]
fn shapes_lights_and_cameras_arrive() {
    use dapple_lights::{AreaShape, Light};
    let scene = load(&file::showcase());
    let s = scene.space.scale as f32;
    assert_eq!(scene.survey.shapes, 2);
    let camera = &scene.cameras[0];
    assert_eq!((&*camera.name, camera.aspect), ("eye", Some(1.5)));
    assert_near(scene.space.to_world(camera.camera.origin), DVec3::new(0.0, 1.0, 8.0));
    let kinds: Vec<&str> = scene
        .lights
        .iter()
        .map(|l| match l {
            Light::Area(a) if matches!(a.shape, AreaShape::Disk { .. }) => "disk",
            Light::Area(_) | Light::Patterned(_) => "area",
            Light::Point(_) => "point",
            Light::Spot(_) => "spot",
            Light::Moving(_) => "moving",
            Light::Distant(_) => "distant",
            Light::Environment(_) => "environment",
        })
        .collect();
    assert_eq!(kinds, ["area", "area", "disk", "spot"]);
    let Light::Spot(spot) = &scene.lights[3] else { panic!() };
    assert_eq!(spot.axis, Vec3::NEG_Z);
    assert_eq!(spot.intensity, Vec3::new(10.0, 5.0, 0.0) * s * s);
    assert!((spot.outer - (1.0 - libm::cos(0.5))).abs() < 1e-6);
    assert!(!scene.warnings.iter().any(|w| w.0.contains("studio environment")));
}

/// Point, spot and directional lights of 683 cd, cd and lx, and an emissive square of radiance 5.
fn photometric_lamps(generator: &str) -> File {
    let mut file = square();
    file.set("asset", json!({ "version": "2.0", "generator": generator }));
    let light = |kind: &str| json!({"type": kind, "intensity": 683.0, "color": [1.0, 0.5, 0.0]});
    let lights = ["point", "spot", "directional"].map(light);
    file.set("extensions", json!({"KHR_lights_punctual": {"lights": lights}}));
    file.set("extensionsUsed", json!(["KHR_lights_punctual"]));
    let node =
        |i: usize| json!({"translation": [0, 0, 3], "extensions": {"KHR_lights_punctual": {"light": i}}});
    file.set("nodes", json!([{"mesh": 0}, node(0), node(1), node(2)]));
    file.set("scenes", json!([{"nodes": [0, 1, 2, 3]}]));
    file.set(
        "materials",
        json!([{"emissiveFactor": [1, 1, 1],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 5}}}]),
    );
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file
}

#[test]
fn units_of_lights_follow_the_generator_or_the_option() {
    use dapple_lights::Light;
    let blender = "Khronos glTF Blender I/O v4.2.60";
    for (generator, asked, divisor) in [
        (blender, LightUnit::Auto, 683.0),
        (blender, LightUnit::Radiometric, 1.0),
        ("by hand", LightUnit::Auto, 1.0),
        ("by hand", LightUnit::Photometric, 683.0),
    ] {
        let options = gltf::Options { light_unit: asked, ..OPTIONS };
        let bytes = photometric_lamps(generator).gltf();
        let scene = gltf::read_bytes(Path::new("test.gltf"), &bytes, &options).unwrap().build().unwrap();
        let s = scene.space.scale as f32;
        let wanted = Vec3::new(683.0, 341.5, 0.0) / divisor;
        let mut seen = [0; 4];
        for light in &scene.lights {
            let (kind, strength) = match light {
                Light::Point(l) => (0, l.intensity / (s * s)),
                Light::Spot(l) => (1, l.intensity / (s * s)),
                Light::Distant(l) => (2, l.irradiance),
                // An emitter is not a punctual light: its radiance stays.
                _ => (3, wanted),
            };
            seen[kind] += 1;
            assert!((strength - wanted).abs().max_element() < 1e-4, "{generator} {asked}: {strength}");
        }
        assert_eq!(seen, [1; 4]);
        assert_eq!(scene.materials[0].emission, Vec3::splat(5.0));
        assert_eq!(scene.light_unit.unwrap().is_photometric, divisor > 1.0);
    }
    assert!(load(&square()).light_unit.is_none());
}

#[test]
fn info_says_what_lights_are_taken_as() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("lamps.gltf");
    let unit = |file: &File| {
        std::fs::write(&path, file.gltf()).unwrap();
        gltf::info(&path, &OPTIONS).unwrap().light_unit
    };
    let taken = unit(&photometric_lamps("Khronos glTF Blender I/O v4.2.60")).unwrap();
    assert!(taken.unit == "photometric" && taken.why.contains("Blender I/O v4.2.60"), "{taken:?}");
    assert_eq!(unit(&photometric_lamps("by hand")).unwrap().unit, "radiometric");
    assert_eq!(unit(&square()), None);
}

#[test]
fn info_counts_without_reading_meshes() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("showcase.glb");
    std::fs::write(&path, file::showcase().glb()).unwrap();
    let info = gltf::info(&path, &OPTIONS).unwrap();
    assert_eq!((info.counts.triangles, info.counts.vertices, info.counts.nodes), (2, 4, 5));
    assert_eq!(info.counts.shapes, load(&file::showcase()).survey.shapes);
    assert_eq!((info.cameras.len(), info.cameras[0].name.as_str()), (1, "eye"));
    assert_eq!((info.lights[0].kind, info.lights[0].name.as_deref()), ("spot", Some("lamp")));
    assert_eq!((info.textures[0].width, info.textures[0].height), (2, 1));
    assert_eq!((info.animations[0].name.as_deref(), info.animations[0].end), (Some("slide"), 2.0));
    assert!(info.extensions.iter().all(|e| e.supported && !e.required));
    assert!(serde_json::to_string(&info).unwrap().contains("\"triangles\":2"));
    let mut strange = file::showcase();
    strange.set("extensionsRequired", json!(["VENDOR_magic"]));
    strange.json["extensions"] = json!({"VENDOR_magic": {}});
    std::fs::write(&path, strange.glb()).unwrap();
    let info = gltf::info(&path, &OPTIONS).unwrap();
    assert!(info.extensions.iter().any(|e| e.name == "VENDOR_magic" && e.required && !e.supported));
    assert!(info.warnings[0].contains("VENDOR_magic"));
}

/// Bytes changed, removed and doubled at random: never a panic, always a scene or one line.
#[test]
fn mutations_never_panic() {
    let whole = file::showcase().glb();
    let mut state = 0x9e37_79b9_u64;
    let mut next = move |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    let mut loaded = 0;
    for round in 0..6000 {
        let mut bytes = whole.clone();
        for _ in 0..1 + next(4) {
            let at = next(bytes.len());
            match next(4) {
                0 => bytes[at] ^= 1 << next(8),
                1 => bytes[at] = next(256) as u8,
                2 => bytes[at] = b"0123456789-{}[],:\"e."[next(20)],
                _ => {
                    let end = (at + next(8)).min(bytes.len());
                    bytes.copy_within(at..end, next(whole.len() - 8));
                }
            }
        }
        match read(&bytes) {
            Ok(_) => loaded += 1,
            Err(e) => assert!(!e.to_string().contains('\n'), "round {round}: {e}"),
        }
    }
    assert!((100..5900).contains(&loaded), "the fuzz tries both good and bad files: {loaded}");
}

/// A square, and a camera that hangs on a node.
fn with_camera(parent: Value, mut own: Value, camera: Value) -> File {
    let mut file = square();
    own["camera"] = json!(0);
    let mut parent = parent;
    parent["children"] = json!([2]);
    file.set("nodes", json!([{"mesh": 0}, parent, own]));
    file.set("scenes", json!([{"nodes": [0, 1]}]));
    file.set("cameras", json!([camera]));
    file
}

fn perspective(more: Value) -> Value {
    let mut all = json!({"yfov": 1.0, "znear": 0.1, "aspectRatio": 1.0});
    all.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    json!({"type": "perspective", "perspective": all})
}

const TURN: [f64; 4] = [-0.2, 0.4, 0.1, 0.888_819_442_1];

#[test]
fn a_camera_ignores_its_scale_and_mirroring() {
    let camera = |parent: Value, own: Value| {
        let scene = load(&with_camera(parent, own, perspective(json!({}))));
        let c = &scene.cameras[0].camera;
        [c.right, c.up, c.backward, scene.space.to_world(c.origin).as_vec3()]
    };
    let at = |node: Value| {
        let mut node = node;
        node["rotation"] = json!(TURN);
        node["translation"] = json!([0.5, -0.25, 2.0]);
        node
    };
    let expected = camera(json!({}), at(json!({})));
    let close = |a: [Vec3; 4]| a.iter().zip(&expected).all(|(a, b)| (*a - *b).length() < 1e-5);
    for i in 0..8 {
        let sign = |bit: u32| if i >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let scale = json!([2.0 * sign(0), 0.5 * sign(1), 3.0 * sign(2)]);
        assert!(close(camera(json!({}), at(json!({"scale": scale})))), "{scale}");
    }
    for scale in [[0.0, 1.0, 1.0], [0.0, 0.0, 0.0]] {
        assert!(close(camera(json!({}), at(json!({"scale": scale})))), "{scale:?}");
    }
    // A parent's scale moves the camera, and turns nothing.
    for scale in [[2.0, 2.0, 2.0], [0.0, 0.0, 0.0]] {
        let [right, up, backward, origin] = camera(json!({"scale": scale}), at(json!({})));
        assert!(close([right, up, backward, expected[3]]), "{scale:?}");
        assert_near(origin.as_dvec3(), DVec3::new(0.5, -0.25, 2.0) * scale[0]);
    }
    // A mirror above it leaves the direction to what it stands before, upright.
    let [right, up, backward, _] = camera(json!({"scale": [-1, 1, 1]}), at(json!({})));
    let mirrored = expected[2] * Vec3::new(-1.0, 1.0, 1.0);
    assert!((backward - mirrored).length() < 1e-5 && up.y > 0.0);
    assert!((right.cross(up) - backward).length() < 1e-5, "right-handed");
    for own in
        [json!({"scale": [1, -1, 1]}), json!({"matrix": [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]})]
    {
        let [right, up, backward, _] = camera(json!({}), own);
        assert_eq!([right, up, backward], [Vec3::X, Vec3::Y, Vec3::Z]);
    }
    let [right, up, backward, _] = camera(json!({"scale": [1, -1, 1]}), json!({}));
    assert_eq!([right, up, backward], [Vec3::X, Vec3::Y, Vec3::Z]);
}

#[test]
fn an_animated_camera_ignores_its_scale() {
    let mut file = with_camera(json!({}), json!({"rotation": TURN}), perspective(json!({})));
    let times = file.scalars(&[0.0, 1.0]);
    let scales = file.floats(&[[1.0, -1.0, 1.0], [0.0, 2.0, -3.0]]);
    let places = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    file.set(
        "animations",
        json!([{
            "samplers": [{"input": times, "output": scales}, {"input": times, "output": places}],
            "channels": [
                {"sampler": 0, "target": {"node": 2, "path": "scale"}},
                {"sampler": 1, "target": {"node": 2, "path": "translation"}},
            ],
        }]),
    );
    let options = gltf::Options { shutter: Shutter { open: 0.0, close: 1.0 }, ..OPTIONS };
    let scene = gltf::read_bytes(Path::new("test.gltf"), &file.gltf(), &options).unwrap().build().unwrap();
    let camera = &scene.cameras[0].camera;
    assert!(camera.motion.is_some());
    let still = load(&with_camera(json!({}), json!({"rotation": TURN}), perspective(json!({}))));
    let still = &still.cameras[0].camera;
    for time in [0.0, 0.3, 0.5, 1.0] {
        let at = camera.at(time);
        for (a, b) in [(at.right, still.right), (at.up, still.up), (at.backward, still.backward)] {
            assert!((a - b).length() < 1e-5, "{time}: {a} {b}");
        }
        assert_near(scene.space.to_world(at.origin), DVec3::X * f64::from(time));
    }
}

#[test]
fn clipping_planes_arrive() {
    use dapple_camera::Clip;
    let clip = |camera: Value| {
        let scene = load(&with_camera(json!({}), json!({}), camera));
        let scale = scene.space.scale as f32;
        let clip = scene.cameras[0].camera.clip.map(|c| Clip { near: c.near / scale, far: c.far / scale });
        (clip, scene.warnings.iter().any(|w| w.to_string().contains("znear")))
    };
    let planes = |near, far| (Some(Clip { near, far }), false);
    assert_eq!(clip(perspective(json!({"znear": 2.0, "zfar": 20.0}))), planes(2.0, 20.0));
    assert_eq!(clip(perspective(json!({"znear": 0.5}))), planes(0.5, f32::INFINITY));
    let parallel = |near: f32, far: f32| json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": near, "zfar": far}});
    assert_eq!(clip(parallel(0.0, 4.0)), planes(0.0, 4.0));
    assert_eq!(clip(parallel(1.0, 4.0)), planes(1.0, 4.0));
    for bad in [parallel(4.0, 1.0), parallel(-1.0, 4.0), perspective(json!({"znear": 3.0, "zfar": 3.0}))] {
        assert_eq!(clip(bad), (None, true));
    }
}
