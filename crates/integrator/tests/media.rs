//! Nested media: bodies inside of bodies, overlapping and touching bodies, cameras inside bodies; with both tracers,
//! from both sides.

mod common;

use common::moving::{AT, SHUTTER, slide};
use common::tracers::{Tracer, one_pixel};
use common::{matte, quad, seen_in_parallel};
use dapple_camera::{Aperture, Camera, Lens};
use dapple_geometry::Mesh;
use dapple_integrator::{Effect, Outcome, Settings, render};
use dapple_materials::Material;
use dapple_sampling::Pattern;
use dapple_scene::{Scene, SceneBuilder, TexturedMaterial};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::ops::ControlFlow;

/// A smooth solid of this index that absorbs `sigma` per unit length.
fn solid(ior: f32, sigma: f32) -> TexturedMaterial {
    let base = Material {
        metallic: 0.0,
        roughness: 0.0,
        ior,
        transmission: 1.0,
        thin: false,
        ..Material::default()
    };
    TexturedMaterial { base, sigma_a: Vec3::splat(sigma), ..TexturedMaterial::default() }
}

/// A closed box with outward normals.
fn cuboid(lo: [f32; 3], hi: [f32; 3]) -> Mesh {
    let at = |i: usize, k: usize| if i >> k & 1 == 1 { hi[k] } else { lo[k] };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(|i| Vec3::new(at(i, 0), at(i, 1), at(i, 2))).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        ..Mesh::default()
    }
}

/// A block across the view from z = a to z = b; blocks of different `width` share no edges.
fn block(width: f32, a: f32, b: f32) -> Mesh {
    cuboid([-width, -width, a], [width, width, b])
}

/// Rotated so that nothing is axis-aligned.
fn turns() -> [DAffine3; 3] {
    let turn = |axis: DVec3, angle| DAffine3::from_quat(DQuat::from_axis_angle(axis.normalize(), angle));
    [DAffine3::IDENTITY, turn(DVec3::new(1.0, 2.0, 0.5), 0.7), turn(DVec3::new(-1.0, 0.3, 2.0), 2.1)]
}

/// A camera on the z axis at `z` that looks along it through the blocks at a wall of radiance 1, with the scene
/// rotated.
fn through(turn: DAffine3, z: f64, forward: bool, add: impl Fn(&mut SceneBuilder)) -> Scene {
    let (d, side) = if forward { (DVec3::NEG_Z, -1.0) } else { (DVec3::Z, 1.0) };
    let at = |p: DVec3| turn.transform_point3(p);
    let mut builder = seen_in_parallel(
        at(DVec3::new(0.11, 0.07, z)),
        turn.transform_vector3(d),
        turn.transform_vector3(DVec3::Y),
        0.01,
    );
    let bright = builder.material(TexturedMaterial { double_sided: true, ..matte(0.0, 1.0) });
    let wall = quad(Vec3::new(-50.0, -50.0, 20.0 * side), Vec3::X * 100.0, Vec3::Y * 100.0);
    builder.mesh("wall", wall, turn, bright);
    add(&mut builder);
    builder.build().unwrap()
}

fn means(scene: &Scene, camera: &Camera, settings: &Settings) -> Outcome {
    let outcome = render(scene, camera, settings, &|_| ControlFlow::Continue(()));
    assert_eq!(outcome.stats.bad_sample_count, 0);
    outcome
}

/// One pixel with a constant value, 64 bounces.
fn straight(tracer: Tracer) -> Settings {
    Settings { max_bounces: 64, ..one_pixel(tracer, Pattern::Random, &[(Effect::Light, [1, 1])], 4) }
}

#[track_caller]
fn assert_seen(what: &str, scene: &Scene, exact: f64) {
    for tracer in [Tracer::Path, Tracer::Nested] {
        let outcome = means(scene, &scene.cameras[0].camera, &straight(tracer));
        let seen = f64::from(outcome.film.mean().pixels[0].x);
        assert!((seen - exact).abs() <= 1e-4 * exact, "{what}, {tracer:?}: {seen}, exact {exact}");
        assert!(outcome.stats.bias.is_clean(), "{what}");
    }
}

const LN_2: f32 = std::f32::consts::LN_2;

#[test]
fn leaving_an_inner_body_brings_back_the_outer_one() {
    for turn in turns() {
        for forward in [true, false] {
            for order in [[0, 1, 2], [2, 1, 0], [1, 0, 2]] {
                let scene = through(turn, if forward { 10.0 } else { -10.0 }, forward, |builder| {
                    let clear = builder.material(solid(1.0, 0.0));
                    let dark = builder.material(solid(1.0, LN_2));
                    for which in order {
                        let (mesh, material) = match which {
                            0 => (block(3.0, 0.0, 3.0), dark),
                            1 => (block(2.0, 0.5, 1.0), clear),
                            _ => (block(2.1, 2.0, 2.5), clear),
                        };
                        builder.mesh("block", mesh, turn, material);
                    }
                });
                assert_seen("two within one", &scene, 0.25);
            }
        }
    }
}

#[test]
fn bodies_that_touch_are_left_and_entered_in_one_place() {
    for turn in turns() {
        for forward in [true, false] {
            let scene = through(turn, if forward { 10.0 } else { -10.0 }, forward, |builder| {
                for (width, a, b, sigma) in
                    [(3.0, 0.0, 1.5, 1.0), (3.0, 1.5, 3.0, 2.0), (2.0, 0.0, 1.0, 0.5), (2.0, 1.0, 1.5, 0.25)]
                {
                    let of = builder.material(solid(1.0, sigma * LN_2));
                    builder.mesh("block", block(width, a, b), turn, of);
                }
            });
            assert_seen("touching", &scene, 2f64.powf(-(0.5 + 0.125 + 3.0)));
        }
    }
}

#[test]
fn a_camera_inside_a_body_starts_in_its_medium() {
    for turn in turns() {
        for forward in [true, false] {
            let scene = through(turn, 1.5, forward, |builder| {
                let dark = builder.material(solid(1.0, LN_2));
                let darker = builder.material(solid(1.0, 2.0 * LN_2));
                builder.mesh("block", block(3.0, 0.0, 3.0), turn, dark);
                builder.mesh("inner", block(2.0, 1.0, 2.0), turn, darker);
            });
            assert_seen("inside of two", &scene, 0.25);
        }
    }
}

#[test]
fn where_bodies_overlap_priority_then_the_smaller_then_the_node_wins() {
    // A from 0 to 2 and B from 1 to 3, absorbing 1 and 2 per unit length: between 1 and 2 the result depends on which
    // of them has priority.
    let exact = |a_wins: bool| 2f64.powf(-if a_wins { 2.0 + 2.0 } else { 1.0 + 4.0 });
    let cases = [
        ("priority of A", 1.0, 0.0, 3.0, 2.0, [0, 1], true),
        ("priority of B", -3.0, -2.5, 2.0, 3.0, [0, 1], false),
        ("A is smaller", 5.0, 5.0, 2.0, 3.0, [1, 0], true),
        ("B is smaller", 0.0, 0.0, 3.0, 2.0, [0, 1], false),
        ("equal, A is the lower node", 0.0, 0.0, 2.0, 2.0, [3, 7], true),
        ("equal, B is the lower node", 0.0, 0.0, 2.0, 2.0, [7, 3], false),
    ];
    for (what, pa, pb, wa, wb, [na, nb], a_wins) in cases {
        for turn in turns() {
            for (forward, z) in [(true, 10.0), (false, -10.0), (true, 1.5), (false, 1.5)] {
                let scene = through(turn, z, forward, |builder| {
                    let a = builder.material(TexturedMaterial { priority: pa, ..solid(1.0, LN_2) });
                    let b = builder.material(TexturedMaterial { priority: pb, ..solid(1.0, 2.0 * LN_2) });
                    let b = builder.mesh("B", block(wb, 1.0, 3.0), turn, b);
                    builder.one_body(b..b + 1, nb);
                    let a = builder.mesh("A", block(wa, 0.0, 2.0), turn, a);
                    builder.one_body(a..a + 1, na);
                });
                let (half, inside) = (if a_wins { 0.5 } else { 1.0 }, z == 1.5);
                let exact = match (inside, forward) {
                    (false, _) => exact(a_wins),
                    (true, true) => 2f64.powf(-half - 1.0),
                    (true, false) => 2f64.powf(-half - 2.0),
                };
                assert_seen(&format!("{what}, {forward}, {z}"), &scene, exact);
            }
        }
    }
}

#[test]
fn several_meshes_of_a_node_are_one_body() {
    // Two overlapping shells of one body: the union is inside, and the inner boundaries are hidden.
    for (forward, z) in [(true, 10.0), (false, -10.0)] {
        let scene = through(DAffine3::IDENTITY, z, forward, |builder| {
            let of = builder.material(solid(1.5, LN_2));
            let first = builder.mesh("a", block(3.0, 0.0, 2.0), DAffine3::IDENTITY, of);
            builder.mesh("b", block(2.0, 1.0, 3.0), DAffine3::IDENTITY, of);
            builder.one_body(first..first + 2, 0);
        });
        let settings = Settings { max_bounces: 200, ..straight(Tracer::Nested) };
        let seen = means(&scene, &scene.cameras[0].camera, &settings).film.mean().pixels[0].x;
        // A slab: T²a/(1 − R²a²), with a = 1/8; the sky is black in the direction of reflections.
        let (r, a) = (0.04f64, 0.125f64);
        let exact = (1.0 - r) * (1.0 - r) * a / (1.0 - r * r * a * a);
        assert!((f64::from(seen) - exact).abs() < 1e-5, "{seen} {exact}");
    }
}

#[test]
fn boundaries_within_a_stronger_body_are_no_bounces() {
    let scene = through(DAffine3::IDENTITY, 10.0, true, |builder| {
        let strong = builder.material(TexturedMaterial { priority: 1.0, ..solid(1.0, LN_2) });
        let weak = builder.material(TexturedMaterial { emission: Vec3::ZERO, ..solid(1.7, 9.0) });
        builder.mesh("strong", block(3.0, 0.0, 3.0), DAffine3::IDENTITY, strong);
        for i in 0..5 {
            let a = 0.5 + 0.25 * i as f32;
            builder.mesh("weak", block(2.0, a, a + 1.0), DAffine3::IDENTITY, weak);
        }
    });
    for tracer in [Tracer::Path, Tracer::Nested] {
        let settings = Settings { max_bounces: 2, ..straight(tracer) };
        let outcome = means(&scene, &scene.cameras[0].camera, &settings);
        let seen = outcome.film.mean().pixels[0].x;
        assert!((seen - 0.125).abs() < 1e-5, "{seen}");
    }
}

/// Reflectance of a smooth interface for light arriving at the cosine `c`.
fn fresnel(c: f64, eta: f64) -> f64 {
    let ct = (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt();
    let (s, p) = ((c - eta * ct) / (c + eta * ct), (eta * c - ct) / (eta * c + ct));
    0.5 * (s * s + p * p)
}

#[test]
fn an_inner_boundary_reflects_by_the_ratio_of_both_indices() {
    // From inside a body of index n₁ onto one of n₂ that absorbs everything; the reflection shows a wall inside the
    // first body.
    for (n1, n2, first_is_outer) in
        [(1.33f32, 1.5f32, true), (1.5, 1.33, true), (1.33, 1.5, false), (1.5, 1.2, false)]
    {
        for slope in [0.0f64, 0.6] {
            let c = 1.0 / (1.0 + slope * slope).sqrt();
            let eta = f64::from(n2) / f64::from(n1);
            let exact = if 1.0 - (1.0 - c * c) / (eta * eta) <= 0.0 { 1.0 } else { fresnel(c, eta) };
            let from = DVec3::new(-slope * 0.5, 0.0, 0.5);
            let mut builder = seen_in_parallel(from, DVec3::new(slope, 0.0, -1.0), DVec3::Y, 1e-3);
            let bright = builder.material(TexturedMaterial { double_sided: true, ..matte(0.0, 1.0) });
            builder.mesh(
                "wall",
                quad(Vec3::new(-8.0, -8.0, 1.0), Vec3::X * 16.0, Vec3::Y * 16.0),
                DAffine3::IDENTITY,
                bright,
            );
            let mine = builder.material(solid(n1, 0.0));
            let other = builder.material(solid(n2, 1e3));
            let (outer, inner) = (block(20.0, -9.0, 9.0), cuboid([-15.0; 3], [15.0, 15.0, 0.0]));
            if first_is_outer {
                builder.mesh("outer", outer, DAffine3::IDENTITY, mine);
                builder.mesh("inner", block(15.0, -8.0, 0.0), DAffine3::IDENTITY, other);
            } else {
                // The camera is in the inner body, and looks out of it.
                builder.mesh("outer", block(40.0, -30.0, 9.0), DAffine3::IDENTITY, other);
                builder.mesh("inner", block(15.0, 0.0, 2.0), DAffine3::IDENTITY, mine);
                let _ = (outer, inner);
            }
            let scene = builder.build().unwrap();
            let settings = Settings { max_bounces: 1, ..straight(Tracer::Nested) };
            let seen = f64::from(means(&scene, &scene.cameras[0].camera, &settings).film.mean().pixels[0].x);
            assert!((seen - exact).abs() < 1e-5, "{n1} {n2} {slope}: {seen}, exact {exact}");
            let many = Settings { max_bounces: 1, ..straight(Tracer::Path) }.with_spp(20_000);
            let outcome = means(&scene, &scene.cameras[0].camera, &many);
            let (seen, error) =
                (f64::from(outcome.film.mean().pixels[0].x), outcome.film.variance().pixels[0].x.sqrt());
            assert!(
                (seen - exact).abs() < 4.0 * f64::from(error) + 1e-5,
                "{n1} {n2} {slope}: {seen}, exact {exact}"
            );
        }
    }
}

#[test]
fn a_lens_half_inside_a_body_sees_half_of_it() {
    // The lens lies in a plane across z, the body on one side of x = 0; parallel rays, the focus is at infinity.
    let mut builder = seen_in_parallel(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1e-5);
    let bright = builder.material(matte(0.0, 1.0));
    builder.mesh(
        "wall",
        quad(Vec3::new(-50.0, -50.0, -20.0), Vec3::X * 100.0, Vec3::Y * 100.0),
        DAffine3::IDENTITY,
        bright,
    );
    let dark = builder.material(solid(1.0, LN_2));
    builder.mesh("block", cuboid([0.0, -3.0, -2.0], [3.0, 3.0, 1.0]), DAffine3::IDENTITY, dark);
    let scene = builder.build().unwrap();
    let lens = Lens {
        aperture: Aperture::Disk,
        radius: scene.space.length_to_render(0.5),
        focus_distance: f32::INFINITY,
    };
    let camera = Camera { lens: Some(lens), ..scene.cameras[0].camera.clone() };
    for tracer in [Tracer::Path, Tracer::Nested, Tracer::Paired] {
        let integrals = [(Effect::Lens, [64, 64])];
        let settings = Settings { max_bounces: 8, ..one_pixel(tracer, Pattern::Sobol, &integrals, 4096) };
        let seen = means(&scene, &camera, &settings).film.mean().pixels[0].x;
        assert!((seen - 0.625).abs() < 2e-3, "{tracer:?}: {seen}");
    }
}

#[test]
fn a_body_that_passes_the_camera_is_there_while_it_passes() {
    let mut builder = seen_in_parallel(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1e-5);
    builder.exposure(AT, SHUTTER);
    let bright = builder.material(matte(0.0, 1.0));
    builder.mesh(
        "wall",
        quad(Vec3::new(-50.0, -50.0, -20.0), Vec3::X * 100.0, Vec3::Y * 100.0),
        DAffine3::IDENTITY,
        bright,
    );
    let dark = builder.material(solid(1.0, LN_2));
    let clear = builder.material(solid(1.0, 0.0));
    // Reaches the camera after a quarter of the time; a clear body inside it halves the absorbing length.
    let chain = slide(DVec3::X * 1.0, DVec3::X * -3.0);
    builder.moving_mesh("block", cuboid([0.0, -3.0, -2.0], [9.0, 3.0, 1.0]), chain.clone(), dark);
    builder.moving_mesh("inner", cuboid([-1.0, -2.0, -1.5], [8.0, 2.0, -0.5]), chain, clear);
    let scene = builder.build().unwrap();
    for tracer in [Tracer::Path, Tracer::Nested, Tracer::Paired] {
        let integrals = [(Effect::Time, [4096, 1])];
        let settings = Settings { max_bounces: 8, ..one_pixel(tracer, Pattern::Sobol, &integrals, 4096) };
        let seen = means(&scene, &scene.cameras[0].camera, &settings).film.mean().pixels[0].x;
        assert!((seen - (0.25 + 0.75 * 0.5)).abs() < 2e-3, "{tracer:?}: {seen}");
    }
}

#[test]
fn more_bodies_than_a_ray_remembers_are_told_of() {
    for (count, clean) in [(16, true), (17, false), (40, false)] {
        let scene = through(DAffine3::IDENTITY, 10.0, true, |builder| {
            let of = builder.material(solid(1.0, 0.01));
            for i in 0..count {
                let r = 3.0 - 0.05 * i as f32;
                builder.mesh("shell", block(r, 2.0 - r, 2.0 + r), DAffine3::IDENTITY, of);
            }
        });
        for tracer in [Tracer::Path, Tracer::Nested] {
            let settings = Settings { max_bounces: 100, ..straight(tracer) };
            let outcome = means(&scene, &scene.cameras[0].camera, &settings);
            assert_eq!(outcome.stats.bias.is_clean(), clean, "{count}");
            assert_eq!(outcome.stats.bias.nested.count == 0, clean, "{count}");
            // The dropped body is the one of lowest priority, here the outermost: its share of the outgoing segment is
            // not absorbed.
            let forgotten = 0.01 * 0.05 * (count as f32 - 16.0).max(0.0);
            let seen = outcome.film.mean().pixels[0].x;
            assert!((seen - (forgotten - 0.06).exp()).abs() < 1e-4, "{count}: {seen}");
        }
    }
}
