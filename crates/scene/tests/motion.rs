//! Animated files with an open shutter: chains of nodes are composed exactly at any time.
#![cfg(feature = "gltf")]
mod file;

use dapple_camera::Shutter;
use dapple_lights::{AreaShape, Light};
use dapple_scene::{Scene, WorldPoint, gltf};
use file::{File, json};
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use std::path::Path;

const AT: f64 = 1.0;
const SHUTTER: Shutter = Shutter { open: 0.25, close: 2.25 };

fn read(file: &File, shutter: Shutter) -> Scene {
    let options = gltf::Options { at: AT, shutter, ..Default::default() };
    gltf::read_bytes(Path::new("test.gltf"), &file.gltf(), &options).unwrap().build().unwrap()
}

fn half_turn_keys(axis: DVec3, degrees: &[f64]) -> Vec<[f32; 4]> {
    let key = |d: &f64| {
        let half = d.to_radians() / 2.0;
        let v = axis * libm::sin(half);
        [v.x, v.y, v.z, libm::cos(half)].map(|x| x as f32)
    };
    degrees.iter().map(key).collect()
}

/// A chain of a root rotated by four linear keys (270° in total), an arm translated by steps, and a hand scaled by a
/// spline, with a card, a ball, an eye and a lamp on the hand.
fn machine() -> File {
    let mut file = File::new();
    let positions = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0_f32]]);
    let indices = file.indices_u16(&[0, 1, 2, 0, 2, 3]);
    let times = file.scalars(&[0.0, 1.0, 2.0, 4.0]);
    let turns = file.floats(&half_turn_keys(DVec3::Y, &[0.0, 90.0, 180.0, 270.0]));
    let jumps = file.floats(&[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 0.0, 0.0_f32]]);
    let ends = file.scalars(&[1.0, 3.0]);
    let (zero, one, two) = ([0.0_f32; 3], [1.0; 3], [2.0; 3]);
    let swell = file.floats(&[zero, one, [0.5; 3], [-0.5; 3], two, zero]);
    file.set("materials", json!([{"emissiveFactor": [1, 1, 1]}]));
    let attributes = json!({"POSITION": positions});
    file.set(
        "meshes",
        json!([{"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}]),
    );
    file.set("cameras", json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]));
    file.set(
        "nodes",
        json!([
            {"name": "root", "children": [1], "translation": [1e4, 0, 0]},
            {"name": "arm", "children": [2], "scale": [1, 1, 1]},
            {"name": "hand", "children": [3, 4, 5, 6], "rotation": [0.6, 0, 0, 0.8]},
            {"name": "card", "mesh": 0, "translation": [0.5, 0, 0]},
            {"name": "ball", "extras": {"dapple": {"shape": "sphere", "radius": 0.5, "material": 0}}},
            {"name": "eye", "camera": 0, "translation": [0, 0, 3]},
            {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 2, 0]},
            {"name": "rest", "mesh": 0, "translation": [9999, 0, 0]},
        ]),
    );
    file.set("scenes", json!([{"nodes": [0, 7]}]));
    file.set(
        "animations",
        json!([{
            "samplers": [
                {"input": times, "output": turns},
                {"input": times, "output": jumps, "interpolation": "STEP"},
                {"input": ends, "output": swell, "interpolation": "CUBICSPLINE"},
            ],
            "channels": [
                {"sampler": 0, "target": {"node": 0, "path": "rotation"}},
                {"sampler": 1, "target": {"node": 1, "path": "translation"}},
                {"sampler": 2, "target": {"node": 2, "path": "scale"}},
            ],
        }]),
    );
    file.set("extensions", json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 3}]}}));
    file.set("extensionsUsed", json!(["KHR_lights_punctual"]));
    file
}

/// Expected transform of the hand at a time of the animation.
fn hand(time: f64) -> DAffine3 {
    let degrees = if time < 2.0 { 90.0 * time } else { (180.0 + 45.0 * (time - 2.0)).min(270.0) };
    let root = DAffine3::from_rotation_translation(
        DQuat::from_rotation_y(degrees.to_radians()),
        DVec3::new(1e4, 0.0, 0.0),
    );
    let jump = [1.0, 2.0, 3.0, 4.0][[1.0, 2.0, 4.0].iter().filter(|&&t| time >= t).count()];
    let s = ((time - 1.0) / 2.0).clamp(0.0, 1.0);
    // Keys two seconds apart with values 1 and 2, out-tangent ½ and in-tangent −½.
    let (s2, s3) = (s * s, s * s * s);
    let swell = (2.0 * s3 - 3.0 * s2 + 1.0) + (s3 - 2.0 * s2 + s) + 2.0 * (3.0 * s2 - 2.0 * s3) - (s3 - s2);
    let turn = DQuat::from_xyzw(0.6, 0.0, 0.0, 0.8);
    root * DAffine3::from_translation(DVec3::new(jump, 0.0, 0.0))
        * DAffine3::from_scale_rotation_translation(DVec3::splat(swell), turn, DVec3::ZERO)
}

#[track_caller]
fn near(a: DVec3, b: DVec3) {
    // The scene is a few units wide, and all data are f32, including keys and vertices.
    assert!((a - b).length() < 2e-5, "{a} instead of {b}");
}

#[test]
fn a_chain_is_composed_at_every_time() {
    let scene = read(&machine(), SHUTTER);
    assert!(scene.survey.has_motion && scene.accel.has_motion());
    let moving: Vec<bool> = (0..3).map(|i| scene.accel.is_moving(i)).collect();
    assert_eq!(moving, [true, true, false], "card, ball and static object");
    for i in 0..=40 {
        let since = 2.0 * i as f32 / 40.0;
        let hand = hand(AT + SHUTTER.open + f64::from(since));
        let world = |p: Vec3| scene.space.to_world(p).0;
        let corners = scene.accel.corners_at(0, 0, since);
        near(world(corners[1]), hand.transform_point3(DVec3::new(1.5, 0.0, 0.0)));
        let camera = scene.cameras[0].camera.at(since);
        near(world(camera.origin), hand.transform_point3(DVec3::Z * 3.0));
        near(camera.backward.as_dvec3(), hand.transform_vector3(DVec3::Z).normalize());
        let mut lights = scene.lights.iter().filter_map(|l| match l {
            Light::Moving(moving) => moving.at(since),
            _ => None,
        });
        let Some(Light::Area(card)) = lights.next() else { panic!() };
        let AreaShape::Quad { corner, e1, e2 } = card.shape else { panic!("{:?}", card.shape) };
        let middle = hand.transform_point3(DVec3::new(1.0, 0.5, 0.0));
        near(world(corner + (e1 + e2) * 0.5), middle);
        near(e1.cross(e2).normalize().as_dvec3(), hand.transform_vector3(DVec3::Z).normalize());
        let Some(Light::Area(ball)) = lights.next() else { panic!() };
        let AreaShape::Sphere { centre, radius } = ball.shape else { panic!("{:?}", ball.shape) };
        near(world(centre), hand.transform_point3(DVec3::ZERO));
        let size = hand.matrix3.x_axis.length() * 0.5;
        assert!((f64::from(radius) / scene.space.scale - size).abs() < 1e-6);
        let Some(Light::Spot(lamp)) = lights.next() else { panic!() };
        near(world(lamp.p), hand.transform_point3(DVec3::Y * 2.0));
        near(lamp.axis.as_dvec3(), hand.transform_vector3(-DVec3::Z).normalize());
    }
}

/// At the opening of the shutter the scene equals that of an instantaneous exposure.
#[test]
fn at_the_opening_it_is_the_picture_of_an_instant() {
    let (open, still) = (read(&machine(), SHUTTER), read(&machine(), Shutter { close: 0.25, ..SHUTTER }));
    assert!(!still.survey.has_motion);
    assert_eq!(open.space, still.space);
    assert_eq!(open.accel.corners(2, 1), still.accel.corners(2, 1));
    near(
        open.space.to_world(open.accel.corners(0, 1)[2]).0,
        still.space.to_world(still.accel.corners(0, 1)[2]).0,
    );
    let (a, b) = (&open.cameras[0].camera, &still.cameras[0].camera);
    assert!(a.motion.is_some() && b.motion.is_none());
    near(open.space.to_world(a.origin).0, still.space.to_world(b.origin).0);
    let rays = [a.at(0.0), b.clone()].map(|c| c.ray((3, 4), Vec2::splat(0.5), (8, 8), Vec2::ZERO));
    near(rays[0].d.as_dvec3(), rays[1].d.as_dvec3());
}

/// A light keeps its selection probability at all points that it reaches at any time while the shutter is open.
#[test]
fn lights_that_move_can_be_chosen_wherever_they_go() {
    let scene = read(&machine(), SHUTTER);
    let choice = scene.light_choice.as_ref().unwrap();
    for i in 0..200 {
        let hand = hand(AT + SHUTTER.open + 0.01 * f64::from(i));
        let p = scene.space.to_render(WorldPoint(hand.transform_point3(DVec3::new(1.0, 0.5, 0.2))));
        let n = hand.transform_vector3(-DVec3::Z).normalize().as_vec3();
        let all: f32 = (0..scene.lights.len()).map(|light| choice.pmf(p, n, light)).sum();
        assert!((all - 1.0).abs() < 1e-5);
        assert!(choice.pmf(p, n, 0) > 0.1, "a card close to the point");
    }
}

/// Random changes of bytes in an animated file never panic: the result is a scene or an error of one line.
#[test]
fn mutations_never_panic() {
    let whole = machine().glb();
    let mut state = 0x51_7c_c1_b7_u64;
    let mut next = move |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    let options = gltf::Options { at: AT, shutter: SHUTTER, ..Default::default() };
    let mut moving = 0;
    for round in 0..4000 {
        let mut bytes = whole.clone();
        for _ in 0..1 + next(3) {
            // Often in the binary data after the JSON.
            let at = if next(2) == 0 { next(bytes.len()) } else { bytes.len() - 1 - next(300) };
            bytes[at] = if next(2) == 0 { next(256) as u8 } else { b"0123456789-{}[],:\"e."[next(20)] };
        }
        let scene = gltf::read_bytes(Path::new("test.gltf"), &bytes, &options).and_then(|b| b.build());
        match scene {
            Ok(scene) => {
                moving += u32::from(scene.survey.has_motion);
                let bounds = scene.accel.bounds();
                assert!(bounds.is_none_or(|(lo, hi)| lo.is_finite() && hi.is_finite()), "round {round}");
            }
            Err(e) => assert!(!e.to_string().contains('\n'), "round {round}: {e}"),
        }
    }
    assert!((100..3900).contains(&moving), "the fuzz tries both good and bad files: {moving}");
}

/// A sphere with a non-uniform animated scale is still sampled as a light at its current position, without a warning.
#[test]
fn a_round_shape_that_does_not_stay_round() {
    let mut file = machine();
    let (zero, flat) = ([0.0_f32; 3], [1.0, 2.0, 1.0]);
    let squeeze = file.floats(&[zero, [1.0; 3], zero, zero, flat, zero]);
    file.json["animations"][0]["samplers"][2]["output"] = json!(squeeze);
    let scene = read(&file, SHUTTER);
    assert!(scene.accel.is_moving(1));
    // The card's quad, the ball, the spot, and the card at rest.
    assert_eq!(scene.lights.len(), 4);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let ball = scene.objects.iter().find(|o| &*o.name == "ball").unwrap().first_light;
    let Light::Moving(light) = &scene.lights[ball as usize] else { panic!("{:?}", scene.lights) };
    assert!(light.at(0.5).is_none() && scene.lights[ball as usize].power(1.0).x > 0.0);
    let (low, high) = scene.accel.bounds().unwrap();
    let p = low + (high - low) * 0.3;
    assert!(scene.light_choice.as_ref().unwrap().pmf(p, Vec3::ZERO, ball as usize) > 0.0);
    assert!(scene.lights[ball as usize].sample(p, Vec2::splat(0.4), 0.5).is_some());
}
