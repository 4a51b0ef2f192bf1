//! Materials, shapes and lights, and their listing by `info`.
use super::*;

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
    // An image that is used as colour and as data gives two textures.
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
    assert_near(scene.space.to_world(camera.camera.origin).0, DVec3::new(0.0, 1.0, 8.0));
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
                // An area light is not a punctual light: its radiance is unchanged.
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
