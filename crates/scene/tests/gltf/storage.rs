//! Storage of numbers: component types, index types, modes, and sparse accessors.
use super::*;

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
    assert_eq!(a.accel.corners(0, 1), b.accel.corners(0, 1));
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
        // Triangle (0,0,0), (x,0,0), (0,x,0) with x the tested value; elements are padded to 4 bytes.
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
            "without base data corner 1 is at 0, and a triangle has no area"
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
fn counts_without_data_do_not_fill_memory() {
    let mut file = square();
    file.json["accessors"][0] = json!({"componentType": 5126, "count": 4_000_000_000_u64, "type": "VEC3"});
    assert!(error(&file).contains("without data"));
    // The limit applies to the sum over all accessors.
    file.json["accessors"][0]["count"] = json!(1 << 20);
    let primitive = json!({"attributes": {"POSITION": 0}});
    file.json["meshes"][0]["primitives"] = json!(vec![primitive; 8]);
    assert!(error(&file).contains("without data"));
}
