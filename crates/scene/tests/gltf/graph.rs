//! Nodes: hierarchy, transforms, visibility, instances and animation.
use super::*;

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
    // (1,0,0) → ×2 +1 → (3,0,0) → rotated by 90° about z → (0,3,0) → translated.
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
        [scene.accel.corners(0, 0), scene.accel.corners(0, 1)]
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
    // Each is shown once: below the parent if that is in the scene, or else as a root.
    for (roots, said) in [(json!([0, 1]), "as the child"), (json!([0]), "as the root")] {
        let scene = load(&with_nodes(json!([{"mesh": 0}, {"children": [0], "mesh": 0}]), roots));
        assert_eq!(scene.survey.objects, if said == "as the child" { 2 } else { 1 });
        assert!(scene.warnings.iter().any(|w| w.0.contains("node 0") && w.0.contains(said)), "{said}");
    }
    // Listed twice, shown once.
    for (nodes, roots) in [
        (json!([{"mesh": 0}]), json!([0, 0, 0])),
        (json!([{"mesh": 0}, {"children": [0, 0]}]), json!([1])),
        (json!([{"mesh": 0}, {"children": [0]}]), json!([1, 0, 0])),
    ] {
        let scene = load(&with_nodes(nodes, roots));
        assert_eq!(scene.survey.objects, 1);
        assert!(scene.warnings.iter().any(|w| w.0.contains("node 0 is listed more than once")));
    }
    // A deep chain must not overflow the stack.
    let n = 100_000;
    let mut nodes: Vec<Value> = (0..n).map(|i| json!({"children": [i + 1]})).collect();
    nodes.push(json!({"mesh": 0}));
    assert_eq!(load(&with_nodes(json!(nodes), json!([0]))).survey.objects, 1);
}

/// Names in lower case and numbers for names are read, with one warning for each kind.
#[test]
fn enumerations_are_read_in_other_spellings() {
    let mut file = square();
    let times = file.scalars(&[0.0, 1.0]);
    let places = file.floats(&[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
    file.json["materials"] =
        json!([{"alphaMode": "blend", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}}]);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.json["meshes"][0]["primitives"][0]["mode"] = json!("TRIANGLES");
    let x = |interpolation: Value| {
        let mut file = file.clone();
        file.set(
            "animations",
            json!([{
                "samplers": [{"input": times, "output": places, "interpolation": interpolation}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "TRANSLATION"}}],
            }]),
        );
        let options = gltf::Options { at: 0.25, ..OPTIONS };
        let scene =
            gltf::read_bytes(Path::new("test.gltf"), &file.gltf(), &options).unwrap().build().unwrap();
        let said = |word: &str| scene.warnings.iter().any(|w| w.0.contains(word));
        assert!(
            said("interpolations") && said("paths") && said("alpha modes") && said("modes of primitives")
        );
        assert_eq!(scene.materials[0].alpha_mode, AlphaMode::Blend);
        corners(&scene, 0, 0)[0].x
    };
    for linear in [json!(9729), json!(0), json!("linear"), json!("Linear")] {
        assert!((x(linear.clone()) - 1.0).abs() < 1e-5, "{linear}");
    }
    for step in [json!(9728), json!(1), json!("step")] {
        assert!(x(step.clone()).abs() < 1e-5, "{step}");
    }
}

#[test]
fn a_scene_may_show_nothing() {
    let mut file = square();
    file.set("scenes", json!([{"name": "empty"}]));
    assert_eq!(load(&file).survey.objects, 0);
}

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
