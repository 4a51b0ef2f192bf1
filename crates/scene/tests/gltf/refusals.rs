//! Errors of invalid files: one line that names the object at fault.
use super::*;

#[test]
fn required_extensions_are_named() {
    let mut file = square();
    file.set("extensionsRequired", json!(["KHR_materials_ior", "VENDOR_magic"]));
    file.json["nodes"][0]["extensions"] = json!({"VENDOR_magic": {}, "KHR_materials_ior": {}});
    let text = error(&file);
    assert!(text.contains("VENDOR_magic") && !text.contains("ior"), "{text}");
    file.set("extensionsRequired", json!([]));
    file.set("extensionsUsed", json!(["KHR_materials_clearcoat", "KHR_xmp_json_ld"]));
    file.json["nodes"][0]["extensions"] =
        json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1}, "KHR_xmp_json_ld": {}});
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

/// Changes one value of the showcase at a time; the message must name its location.
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

/// Random changes and copies of bytes never panic: the result is a scene or an error of one line.
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
