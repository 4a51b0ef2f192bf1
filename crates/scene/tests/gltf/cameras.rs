//! Cameras: orientation and clipping planes.
use super::*;
use glam::{DMat3, DMat4, DQuat};

/// A square, and a camera on a node with a parent.
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

/// Right, up and backward axis and position of a camera on node `own` below node `parent`.
fn camera(parent: Value, own: Value) -> [Vec3; 4] {
    let scene = load(&with_camera(parent, own, perspective(json!({}))));
    let c = &scene.cameras[0].camera;
    [c.right, c.up, c.backward, scene.space.to_world(c.origin).0.as_vec3()]
}

#[test]
fn a_camera_ignores_its_scale_and_mirroring() {
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
    // A parent's scale moves the camera, but does not rotate it.
    for scale in [[2.0, 2.0, 2.0], [0.0, 0.0, 0.0]] {
        let [right, up, backward, origin] = camera(json!({"scale": scale}), at(json!({})));
        assert!(close([right, up, backward, expected[3]]), "{scale:?}");
        assert_near(origin.as_dvec3(), DVec3::new(0.5, -0.25, 2.0) * scale[0]);
    }
    // A mirroring parent mirrors the viewing direction; the image stays upright.
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

/// A glTF matrix whose upper left part is `m`.
fn matrix(m: DMat3) -> Value {
    json!({"matrix": DMat4::from_mat3(m).to_cols_array()})
}

/// Whatever the scale, mirroring and shear of a camera's node and its parent, the axes are orthonormal and
/// right-handed, the camera looks along the image of −z, and its up axis is on the side of the image of +y, or upwards
/// if mirrored.
#[test]
fn a_camera_is_right_handed_below_everything() {
    let turn = DMat3::from_quat(DQuat::from_array(TURN).normalize());
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.4, 1.0, -0.2), DVec3::new(0.0, 0.3, 1.0));
    let scales = (0..8).map(|i: u32| {
        let signed = |bit: u32, length: f64| if i >> bit & 1 == 1 { -length } else { length };
        DMat3::from_diagonal(DVec3::new(signed(0, 2.0), signed(1, 0.5), signed(2, 1.5)))
    });
    for scale in scales {
        for (parent, own) in [
            (DMat3::IDENTITY, turn * scale),
            (scale, turn),
            (scale * shear, turn),
            (shear, turn * scale),
            (turn * scale, shear * turn),
        ] {
            let [right, up, backward, _] = camera(matrix(parent), matrix(own)).map(|axis| axis.as_dvec3());
            let off =
                DMat3::from_cols(right, up, backward) - DMat3::from_cols(up.cross(backward), up, backward);
            assert!(off.to_cols_array().iter().all(|x| x.abs() < 1e-6), "{parent} {own}");
            assert!((up.dot(backward)).abs() < 1e-6 && (up.length() - 1.0).abs() < 1e-6);
            let all = parent * own;
            assert_near(backward, all.z_axis.normalize());
            let is_mirrored = all.determinant() < 0.0;
            assert!(if is_mirrored { up.y > 0.0 } else { up.dot(all.y_axis) > 0.0 }, "{parent} {own}");
            if parent == DMat3::IDENTITY && scale.z_axis.z > 0.0 && (is_mirrored || scale.y_axis.y > 0.0) {
                assert_near(right, turn.x_axis);
            }
        }
    }
}

#[test]
fn a_camera_below_something_flat_keeps_its_rotation() {
    let turn = DMat3::from_quat(DQuat::from_array(TURN).normalize());
    let expected = camera(json!({}), json!({"rotation": TURN}));
    for scale in [[1.0, 1.0, 0.0], [0.0, 2.0, 1.0], [1.0, 0.0, 0.0]] {
        let got = camera(json!({"scale": scale}), json!({"rotation": TURN}));
        assert!(got.iter().zip(&expected).all(|(a, b)| (*a - *b).length() < 1e-5), "{scale:?}");
        let flat = turn * DMat3::from_diagonal(DVec3::from_array(scale));
        if scale.iter().filter(|s| **s == 0.0).count() == 1 {
            let got = camera(json!({}), matrix(flat));
            assert!(got.iter().zip(&expected).all(|(a, b)| (*a - *b).length() < 1e-5), "{scale:?}");
        }
    }
}

#[test]
fn a_camera_that_moves_below_a_mirror_is_right_handed() {
    let mut file =
        with_camera(json!({"scale": [-2, 1, 1]}), json!({"rotation": TURN}), perspective(json!({})));
    let times = file.scalars(&[0.0, 1.0]);
    let places = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    file.set(
        "animations",
        json!([{
            "samplers": [{"input": times, "output": places}],
            "channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}}],
        }]),
    );
    let options = gltf::Options { shutter: Shutter { open: 0.0, close: 1.0 }, ..OPTIONS };
    let scene = gltf::read_bytes(Path::new("test.gltf"), &file.gltf(), &options).unwrap().build().unwrap();
    let still = camera(json!({"scale": [-2, 1, 1]}), json!({"rotation": TURN}));
    for time in [0.0, 0.5, 1.0] {
        let at = scene.cameras[0].camera.at(time);
        for (a, b) in [at.right, at.up, at.backward].iter().zip(&still) {
            assert!((*a - *b).length() < 1e-5, "{time}: {a} {b}");
        }
        assert_near(scene.space.to_world(at.origin).0, DVec3::NEG_X * 2.0 * f64::from(time));
    }
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
        assert_near(scene.space.to_world(at.origin).0, DVec3::X * f64::from(time));
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
