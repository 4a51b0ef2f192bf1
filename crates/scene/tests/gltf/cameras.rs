//! Cameras: where they look, and what they cut off.
use super::*;

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
