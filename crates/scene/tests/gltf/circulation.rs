//! Irregularities of real-world files and the warnings about them, and access to other files.
use super::*;

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

/// Warnings name the extensions that a file uses, declared or not; extensions that are only declared give no warning.
#[test]
fn extensions_are_known_by_their_use() {
    let mut file = square();
    file.set("extensionsUsed", json!(["KHR_materials_sheen"]));
    file.set("materials", json!([{"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}}]));
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let said = |word: &str| load(&file).warnings.iter().any(|w| w.0.contains(word));
    assert!(said("KHR_materials_clearcoat") && !said("sheen"));
}

/// Extensions without effect on the visible parts give no warning.
#[test]
fn extensions_without_effect_are_not_warned_of() {
    let clearcoat =
        |factor: f64| json!({"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": factor}}});
    let warned = |change: &dyn Fn(&mut File)| {
        let mut file = square();
        file.set("materials", json!([{}, clearcoat(1.0), clearcoat(0.0)]));
        file.json["meshes"][0]["primitives"][0]["material"] = json!(1);
        change(&mut file);
        load(&file).warnings.iter().any(|w| w.0.contains("is not supported"))
    };
    assert!(warned(&|_| {}));
    for material in [0, 2] {
        assert!(!warned(&|file| file.json["meshes"][0]["primitives"][0]["material"] = json!(material)));
    }
    // The mesh is in another scene, or hidden.
    assert!(!warned(&|file| file.set("scenes", json!([{"nodes": []}, {"nodes": [0]}]))));
    assert!(!warned(&|file| {
        file.json["nodes"][0]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    }));
    // Levels of detail, and sound.
    let harmless = json!({"MSFT_lod": {"ids": [1]}, "KHR_audio_emitter": {"emitter": 0}});
    assert!(!warned(&|file| {
        file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        file.json["nodes"][0]["extensions"] = harmless.clone();
    }));
    // A variant that is not selected.
    let mapped = json!({"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}});
    assert!(!warned(&|file| {
        file.set("extensions", json!({"KHR_materials_variants": {"variants": [{"name": "coated"}]}}));
        file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        file.json["meshes"][0]["primitives"][0]["extensions"] = mapped.clone();
    }));
}

#[test]
fn morph_targets_are_missed_where_they_would_show() {
    let warned = |mesh: Value, node: Value| {
        let mut file = square();
        let primitive = &mut file.json["meshes"][0]["primitives"][0];
        primitive["targets"] = json!([{"POSITION": primitive["attributes"]["POSITION"]}]);
        file.json["meshes"][0]["weights"] = mesh;
        file.json["nodes"][0]["weights"] = node;
        load(&file).warnings.iter().any(|w| w.0.contains("morph targets"))
    };
    assert!(
        !warned(json!(null), json!(null))
            && !warned(json!([0]), json!(null))
            && !warned(json!([1]), json!([0]))
    );
    assert!(warned(json!([1]), json!(null)) && warned(json!([0]), json!([0.5])));
}

#[test]
fn a_mesh_that_is_compressed_alone_is_left_out_with_one_warning() {
    let mut file = square();
    file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    file.json["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": {}});
    let scene = load(&file);
    assert_eq!(scene.survey.objects, 0);
    let said: Vec<_> = scene.warnings.iter().filter(|w| !w.0.contains("studio")).collect();
    assert!(said.len() == 1 && said[0].0.contains("no uncompressed copy are left out"), "{said:?}");
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
    let renamed = |scene: &Scene| scene.warnings.iter().any(|w| w.0.contains("is used: correct the name"));
    assert!(!renamed(&found), "{:?}", found.warnings);
    for uri in ["textures\\a b.png", "Textures/A%20b.PNG", "TEXTURES\\A b.png"] {
        let other = try_uri(uri, true).unwrap_or_else(|e| panic!("{uri}: {e}"));
        assert!(renamed(&other), "{uri}");
        assert_eq!(other.materials[0].base, found.materials[0].base);
    }
    // Missing image: the base colour factor remains, and emission that the texture would modulate is off.
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
