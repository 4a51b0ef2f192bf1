//! Visibility of camera rays versus light: clipping planes and back faces, in both tracers.

mod common;

use common::moving::{AT, SHUTTER, slide};
use common::tracers::{Tracer, one_pixel};
use common::{blurred_mirror, clear, irradiance_meter, matte, quad, seen, shadeless, with_lens};
use dapple_camera::{Aperture, Camera, Clip, Projection};
use dapple_geometry::Mesh;
use dapple_integrator::{Aov, Backfaces, Effect, Outcome, Settings, render};
use dapple_lights::Environment;
use dapple_math::motion::Node;
use dapple_sampling::Pattern;
use dapple_scene::{AlphaMode, CameraPose, Scene, SceneBuilder, TexturedMaterial};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Radiance of the sky.
const SKY: f32 = 8.0;

fn settings(tracer: Tracer) -> Settings {
    let all = &[(Effect::Light, [1, 1]), (Effect::Lens, [2, 2]), (Effect::Time, [2, 1])];
    Settings { max_bounces: 64, size: (5, 5), ..one_pixel(tracer, Pattern::Random, all, 4) }
}

fn picture(scene: &Scene, camera: &Camera, settings: &Settings) -> Outcome {
    let outcome = render(scene, camera, settings, &|_| ControlFlow::Continue(()));
    assert_eq!(outcome.stats.bad_sample_count, 0);
    outcome
}

/// Asserts that every pixel shows `expected`, in both tracers, with and without first-hit layers.
#[track_caller]
fn assert_shows(what: &str, scene: &Scene, camera: &Camera, backfaces: Backfaces, expected: f32) {
    for tracer in [Tracer::Path, Tracer::Nested] {
        for general in [false, true] {
            let settings = Settings { backfaces, general, ..settings(tracer) };
            for p in picture(scene, camera, &settings).film.mean().pixels {
                let off = (p - Vec3::splat(expected)).abs().max_element();
                assert!(
                    off <= 2e-5 * expected.max(1.0),
                    "{what}, {backfaces}, {tracer:?}: {p}, not {expected}"
                );
            }
        }
    }
}

/// A square across the view at a depth, facing the camera or away from it.
fn wall(depth: f32, faces_camera: bool) -> Mesh {
    let side = if faces_camera { 1.0 } else { -1.0 };
    quad(Vec3::new(-50.0 * side, -50.0, -depth), Vec3::X * 100.0 * side, Vec3::Y * 100.0)
}

/// A camera at the origin, looking along −z, with these clipping planes in world units.
fn look(projection: Option<f32>, near: f32, far: f32) -> (SceneBuilder, CameraPose) {
    let pose = CameraPose::look_at(DVec3::ZERO, -DVec3::Z, DVec3::Y, 1.2);
    let projection =
        projection.map_or(pose.projection, |half_height| Projection::Orthographic { half_height });
    let mut builder = SceneBuilder::new("test");
    builder.environment(Environment::constant(Vec3::splat(SKY)));
    (builder, CameraPose { projection, clip: Some(Clip { near, far }), ..pose })
}

/// Walls at depths 1, 3 and 6 with radiance 1, 2 and 4.
fn walls(builder: &mut SceneBuilder) {
    for (depth, radiance) in [(1.0, 1.0), (3.0, 2.0), (6.0, 4.0)] {
        let material = builder.material(shadeless(radiance));
        builder.mesh("wall", wall(depth, true), DAffine3::IDENTITY, material);
    }
}

#[test]
fn planes_clip_by_depth() {
    let none = f32::INFINITY;
    for (near, far, expected) in [
        (0.0, none, 1.0),
        (0.5, 1.5, 1.0),
        (0.99, none, 1.0),
        (1.01, none, 2.0),
        (2.9, 3.1, 2.0),
        (1.5, 2.5, SKY),
        (3.1, none, 4.0),
        (0.0, 0.9, SKY),
        (7.0, none, SKY),
    ] {
        for projection in [None, Some(2.0)] {
            let (mut builder, pose) = look(projection, near, far);
            builder.camera("camera", pose);
            walls(&mut builder);
            let scene = builder.build().unwrap();
            let what = format!("{near} to {far}, {projection:?}");
            let camera = &scene.cameras[0].camera;
            assert_shows(&what, &scene, camera, Backfaces::Camera, expected);
            assert_shows(&what, &scene, camera, Backfaces::Shown, expected);
            let lens = with_lens(&scene, Aperture::Disk, 0.2, 2.0);
            assert_shows(&format!("{what}, with a lens"), &scene, &lens, Backfaces::Camera, expected);
        }
    }
}

#[test]
fn planes_move_with_their_camera() {
    for (near, far, expected) in [(1.01, 20.0, 2.0), (3.1, 20.0, 4.0), (1.5, 2.5, SKY)] {
        let (mut builder, pose) = look(None, near, far);
        builder.exposure(AT, SHUTTER);
        builder.moving_camera("camera", pose, slide(DVec3::ZERO, DVec3::new(1.0, 0.5, 0.0)));
        walls(&mut builder);
        let scene = builder.build().unwrap();
        assert!(scene.cameras[0].camera.motion.is_some());
        assert_shows("moving", &scene, &scene.cameras[0].camera, Backfaces::Camera, expected);
    }
}

#[test]
fn first_hits_lie_behind_the_near_plane() {
    let (mut builder, pose) = look(None, 2.0, 20.0);
    builder.camera("camera", pose);
    walls(&mut builder);
    let scene = builder.build().unwrap();
    for tracer in [Tracer::Path, Tracer::Nested] {
        let settings = Settings { aovs: vec![Aov::Depth, Aov::ObjectId], ..settings(tracer) };
        let outcome = picture(&scene, &scene.cameras[0].camera, &settings);
        let layer = |aov: Aov| {
            let layers = &outcome.layers.layers;
            layers.iter().find(|layer| layer.name == aov.to_string()).unwrap().channels[0].1.clone()
        };
        assert!(layer(Aov::Depth).iter().all(|depth| (depth - 3.0).abs() < 1e-5));
        assert!(layer(Aov::ObjectId).iter().all(|id| *id == 2.0));
    }
    let depth =
        dapple_integrator::first_hit::centre_depth(&scene, &scene.cameras[0].camera, Backfaces::Camera);
    assert!((depth.unwrap() / scene.space.scale as f32 - 3.0).abs() < 1e-5);
}

/// A closed box between two depths, with outward normals.
fn block(from: f32, to: f32) -> Mesh {
    let at = |i: usize| {
        let side = |bit: usize| if i >> bit & 1 == 1 { 9.0 } else { -9.0 };
        Vec3::new(side(0), side(1), if i >> 2 & 1 == 1 { -from } else { -to })
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(at).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        ..Mesh::default()
    }
}

/// An absorbing medium with the index of the outside.
fn fog(sigma: f32) -> TexturedMaterial {
    let mut fog = TexturedMaterial { sigma_a: Vec3::splat(sigma), ..clear(0.0, 1.0) };
    fog.base.thin = false;
    fog
}

/// A ray starts at the near plane: inside the medium there, and without absorption in front of the plane.
#[test]
fn media_are_those_at_the_near_plane() {
    for (near, far, way, lit) in [
        (0.0, 20.0, 2.0, 4.0),
        (1.5, 20.0, 1.5, 4.0),
        (2.25, 20.0, 0.75, 4.0),
        (3.5, 20.0, 0.0, 4.0),
        // Surfaces seen through clear matter are clipped as well.
        (2.25, 5.0, 0.75, SKY),
    ] {
        for projection in [None, Some(2.0)] {
            let (mut builder, pose) = look(projection, near, far);
            builder.camera(
                "camera",
                CameraPose {
                    projection: projection
                        .map_or(Projection::Perspective { tan_half: 1e-3 }, |half_height| {
                            Projection::Orthographic { half_height }
                        }),
                    ..pose
                },
            );
            let fog = builder.material(fog(0.7));
            builder.mesh("fog", block(1.0, 3.0), DAffine3::IDENTITY, fog);
            let bright = builder.material(shadeless(4.0));
            builder.mesh("wall", wall(6.0, true), DAffine3::IDENTITY, bright);
            let scene = builder.build().unwrap();
            let expected = lit * (-0.7 * way as f32).exp();
            assert_shows(
                &format!("{near} to {far}"),
                &scene,
                &scene.cameras[0].camera,
                Backfaces::Camera,
                expected,
            );
        }
    }
}

/// A card of this material at depth 1, seen from its back or its front, in front of a wall of radiance 2.
fn card(material: TexturedMaterial, faces_camera: bool, transform: DAffine3) -> Scene {
    let (mut builder, pose) = look(None, 0.0, f32::INFINITY);
    builder.camera("camera", pose);
    let material = builder.material(material);
    builder.mesh("card", wall(1.0, faces_camera), transform, material);
    let bright = builder.material(shadeless(2.0));
    builder.mesh("wall", wall(3.0, true), DAffine3::IDENTITY, bright);
    builder.build().unwrap()
}

#[track_caller]
fn assert_card(what: &str, scene: &Scene, [camera, shown, culled]: [f32; 3]) {
    let view = &scene.cameras[0].camera;
    assert_shows(what, scene, view, Backfaces::Camera, camera);
    assert_shows(what, scene, view, Backfaces::Shown, shown);
    assert_shows(what, scene, view, Backfaces::Culled, culled);
}

#[test]
fn camera_rays_pass_backs_of_single_sided_opaque_materials() {
    let still = DAffine3::IDENTITY;
    let lit = || matte(0.0, 5.0);
    assert_card("its back", &card(lit(), false, still), [2.0, 0.0, 2.0]);
    assert_card("its front", &card(lit(), true, still), [5.0, 5.0, 5.0]);
    assert_card("both sides", &card(shadeless(5.0), false, still), [5.0, 5.0, 5.0]);
    let unlit = TexturedMaterial { unlit: true, ..matte(0.5, 0.0) };
    assert_card("unlit", &card(unlit, false, still), [2.0, 0.5, 2.0]);
    let mask = TexturedMaterial { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, alpha: 0.9, ..lit() };
    assert_card("mask", &card(mask, false, still), [2.0, 0.0, 2.0]);
    let blend = TexturedMaterial { alpha_mode: AlphaMode::Blend, alpha: 1.0 - f32::EPSILON, ..lit() };
    assert_card("blend", &card(blend, false, still), [2.0, 0.0, 2.0]);
    let mut pane = clear(0.0, 1.0);
    pane.base.base_color = Vec3::splat(0.5);
    assert_card("a pane", &card(pane, false, still), [1.0, 1.0, 2.0]);
}

/// The front of a mirrored object is the image of its front (glTF 2.0, §3.7.4).
#[test]
fn mirrored_objects_keep_their_front() {
    let mirrored = |x, y, z| DAffine3::from_scale(DVec3::new(x, y, z));
    for (transform, expected) in [
        (mirrored(-1.0, 1.0, 1.0), [5.0; 3]),
        (mirrored(1.0, -2.0, 1.0), [5.0; 3]),
        (mirrored(-1.0, -1.0, 1.0), [5.0; 3]),
    ] {
        assert_card("mirrored", &card(matte(0.0, 5.0), true, transform), expected);
        assert_card("mirrored", &card(matte(0.0, 5.0), false, transform), [2.0, 0.0, 2.0]);
        for faces_camera in [true, false] {
            let (mut builder, pose) = look(None, 0.0, f32::INFINITY);
            builder.exposure(AT, SHUTTER);
            builder.camera("camera", pose);
            let [card, bright] = [matte(0.0, 5.0), shadeless(2.0)].map(|m| builder.material(m));
            let mut chain = slide(DVec3::ZERO, DVec3::X);
            chain.push(Node::Fixed(transform));
            builder.moving_mesh("card", wall(1.0, faces_camera), chain, card);
            builder.mesh("wall", wall(3.0, true), DAffine3::IDENTITY, bright);
            let scene = builder.build().unwrap();
            assert!(scene.accel.has_motion());
            assert_card("moving", &scene, if faces_camera { expected } else { [2.0, 0.0, 2.0] });
        }
    }
    // The mirror reverses the orientation.
    let behind = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 1.0, -1.0),
        glam::DQuat::IDENTITY,
        DVec3::Z * -2.0,
    );
    assert_card("from behind", &card(matte(0.0, 5.0), true, behind), [2.0, 0.0, 2.0]);
}

/// Behind a pane, camera rays remain camera rays; reflected rays hit both sides.
#[test]
fn panes_show_what_is_seen_without_them() {
    let behind = |first: TexturedMaterial, depth: f32| {
        let (mut builder, pose) = look(None, 0.0, f32::INFINITY);
        builder.camera("camera", pose);
        let [first, card, bright] = [first, matte(0.0, 5.0), shadeless(2.0)].map(|m| builder.material(m));
        builder.mesh("first", wall(1.0, true), DAffine3::IDENTITY, first);
        let side = depth.signum();
        // Its back faces the camera.
        builder.mesh("card", wall(depth, side < 0.0), DAffine3::IDENTITY, card);
        builder.mesh("wall", wall(4.0 * side, true), DAffine3::IDENTITY, bright);
        builder.build().unwrap()
    };
    assert_card("through a pane", &behind(clear(0.0, 1.0), 2.0), [2.0, 0.0, 2.0]);
    // In a mirror, behind the camera.
    assert_card("in a mirror", &behind(blurred_mirror(0.0), -2.0), [0.0, 0.0, 2.0]);
}

/// Of two coincident faces, back to back, the front is visible, whichever comes first in the file.
#[test]
fn of_two_backs_in_one_place_the_front_is_seen() {
    for first_faces in [true, false] {
        let (mut builder, pose) = look(None, 0.0, f32::INFINITY);
        builder.camera("camera", pose);
        for faces in [first_faces, !first_faces] {
            let unlit = TexturedMaterial { unlit: true, ..matte(if faces { 0.7 } else { 0.2 }, 0.0) };
            let material = builder.material(unlit);
            builder.mesh("card", wall(1.0, faces), DAffine3::IDENTITY, material);
        }
        let scene = builder.build().unwrap();
        assert_shows("back to back", &scene, &scene.cameras[0].camera, Backfaces::Camera, 0.7);
    }
}

/// From outside, a room is visible through the back of its single-sided ceiling. A surface whose back faces the floor
/// blocks the sun, unless back faces are culled for all rays.
#[test]
fn light_meets_both_sides() {
    let room = |backfaces, sun: bool| {
        let mut builder = irradiance_meter();
        builder.environment(Environment::constant(Vec3::ZERO));
        let black = builder.material(matte(0.0, 0.0));
        // Between the camera and the floor, facing the floor; or above the camera, facing up.
        let (y, side) = if sun { (2.0, -1.0) } else { (0.4, 1.0) };
        let ceiling = quad(Vec3::new(-9.0, y, -9.0 * side), Vec3::X * 18.0, Vec3::Z * 18.0 * side);
        builder.mesh("ceiling", ceiling, DAffine3::IDENTITY, black);
        match sun {
            true => builder.distant_light(DVec3::Y, Vec3::ONE),
            false => builder.point_light(DVec3::Y * 0.2, Vec3::splat(0.08), f64::INFINITY),
        }
        let scene = builder.build().unwrap();
        [Tracer::Path, Tracer::Nested].map(|tracer| {
            let settings = Settings { backfaces, ..one_pixel(tracer, Pattern::Random, &[], 4) };
            f64::from(picture(&scene, &scene.cameras[0].camera, &settings).film.mean().pixels[0].x)
        })
    };
    let (lamp, sun) = (0.08 / 0.04 / PI, 1.0 / PI);
    for (backfaces, by_lamp, by_sun) in
        [(Backfaces::Camera, lamp, 0.0), (Backfaces::Shown, 0.0, 0.0), (Backfaces::Culled, lamp, sun)]
    {
        for (got, exact) in [(room(backfaces, false), by_lamp), (room(backfaces, true), by_sun)] {
            for got in got {
                assert!((got - exact).abs() < 1e-5, "{backfaces}: {got}, not {exact}");
            }
        }
    }
}

/// A camera frame that is wider than the image is still entirely in view.
#[test]
fn the_frame_is_not_cropped() {
    let mut builder = seen(DVec3::Z * 5.0, DVec3::ZERO, 1.0);
    let white = builder.material(shadeless(1.0));
    let mark = |x: f32| quad(Vec3::new(x - 0.1, -0.1, 0.0), Vec3::X * 0.2, Vec3::Y * 0.2);
    // At nine tenths of a frame that is twice as wide as high.
    let edge = 0.9 * 2.0 * 5.0 * 0.5f32.tan();
    builder.mesh("left", mark(-edge), DAffine3::IDENTITY, white);
    builder.mesh("right", mark(edge), DAffine3::IDENTITY, white);
    builder.environment(Environment::constant(Vec3::ZERO));
    let scene = builder.build().unwrap();
    let camera = Camera { aspect: Some(2.0), ..scene.cameras[0].camera.clone() };
    for size in [(200, 100), (100, 100), (100, 300), (300, 100)] {
        let settings = Settings { size, max_bounces: 0, ..Settings::default() }.with_spp(4);
        let picture = picture(&scene, &camera, &settings).film.mean();
        for half in [0, picture.width / 2] {
            let columns = half..half + picture.width / 2;
            let is_lit =
                columns.into_iter().any(|x| picture.pixels[picture.height / 2 * picture.width + x].x > 0.0);
            assert!(is_lit, "{size:?}");
        }
    }
}
