//! Transparent solids in contact with other surfaces: a glass on a table, coincident walls. The opaque surface wins,
//! whichever of the two comes first in the scene or is nearer by rounding; and bodies that nearly touch keep their
//! media.

mod common;

use common::tracers::{Tracer, one_pixel};
use common::{matte, pane, quad, run, seen, seen_in_parallel};
use dapple_geometry::Mesh;
use dapple_integrator::Settings;
use dapple_lights::Environment;
use dapple_sampling::Pattern;
use dapple_scene::{Scene, SceneBuilder, TexturedMaterial};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::f64::consts::PI;

/// A smooth transparent grey material of this index.
fn clear(ior: f32, thin: bool, color: f32) -> TexturedMaterial {
    pane(ior, thin, Vec3::splat(color))
}

/// A horizontal square of half side `r` about (0, y, 0) that faces up.
fn sheet(r: f32, y: f32) -> Mesh {
    quad(Vec3::new(-r, y, r), Vec3::X * 2.0 * r, Vec3::Z * -2.0 * r)
}

/// A closed box of half side `r` from y = 0 to y = 1, whose vertices differ from those of the sheets.
fn block(r: f32) -> Mesh {
    let at = |i: u32| {
        let side = |bit: u32| if i & bit != 0 { 1.1 * r } else { -r };
        Vec3::new(side(1), if i & 2 != 0 { 1.0 } else { 0.0 }, side(4))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(at).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        ..Mesh::default()
    }
}

/// Positions at which coordinates round differently.
fn places() -> [DAffine3; 3] {
    let turn = |axis: DVec3, angle| DQuat::from_axis_angle(axis.normalize(), angle);
    [
        DAffine3::IDENTITY,
        DAffine3::from_rotation_translation(
            turn(DVec3::new(1.0, 2.0, 3.0), 1.1),
            DVec3::new(7.0, -3.0, 11.0),
        ),
        DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.01),
            turn(DVec3::new(-2.0, 1.0, 0.5), 2.3),
            DVec3::new(0.3, 40.0, -0.7),
        ),
    ]
}

/// The object on the floor.
#[derive(Clone, Copy, Debug)]
enum On {
    Block(f32),
    Wall(f32),
}

/// A floor with a transparent object on it, a lamp below the floor and a distant light above, seen from above.
fn table(place: DAffine3, on: On, floor_first: bool, floor: f32, [lamp, sun]: [f32; 2]) -> Scene {
    let at = |p: DVec3| place.transform_point3(p);
    let mut builder = seen(at(DVec3::new(0.3, 4.0, 0.2)), at(DVec3::new(0.07, 0.0, 0.03)), 0.2);
    let floor = builder.material(matte(floor, 0.0));
    let lamp = builder.material(matte(0.0, lamp));
    let put_floor = |builder: &mut SceneBuilder| builder.mesh("floor", sheet(1.9, 0.0), place, floor);
    if floor_first {
        put_floor(&mut builder);
    }
    match on {
        On::Block(ior) => {
            let clear = builder.material(clear(ior, false, 1.0));
            builder.mesh("block", block(1.0), place, clear);
        }
        On::Wall(ior) => {
            let clear = builder.material(clear(ior, true, 1.0));
            builder.mesh("wall", sheet(1.3, 0.0), place, clear);
        }
    }
    if !floor_first {
        put_floor(&mut builder);
    }
    builder.mesh("lamp", sheet(1.7, -2.0), place, lamp);
    builder.environment(Environment::constant(Vec3::ZERO));
    if sun > 0.0 {
        builder.distant_light(place.transform_vector3(DVec3::Y).normalize(), Vec3::splat(sun));
    }
    builder.build().unwrap()
}

fn settings(tracer: Tracer) -> Settings {
    Settings { size: (8, 8), max_bounces: 6, ..one_pixel(tracer, Pattern::Random, &[], 16) }
}

#[test]
fn nothing_shines_through_a_table_with_glass_on_it() {
    for place in places() {
        for on in [On::Block(1.0), On::Block(1.5), On::Wall(1.0), On::Wall(1.5)] {
            for floor_first in [true, false] {
                let scene = table(place, on, floor_first, 0.0, [100.0, 0.0]);
                for tracer in [Tracer::Path, Tracer::Nested] {
                    let film = run(&scene, &settings(tracer)).film.mean();
                    let most = film.pixels.iter().map(|p| p.max_element()).fold(0.0, f32::max);
                    assert_eq!(most, 0.0, "{on:?} {floor_first} {tracer:?} {place:?}");
                }
            }
        }
    }
}

/// A distant light of irradiance π straight from above, on grey: .5, as without the glass.
#[test]
fn a_table_under_matter_that_bends_no_light_is_seen_as_without() {
    for place in places() {
        for on in [On::Block(1.0), On::Wall(1.0)] {
            for floor_first in [true, false] {
                let scene = table(place, on, floor_first, 0.5, [0.0, PI as f32]);
                for tracer in [Tracer::Path, Tracer::Nested] {
                    let film = run(&scene, &settings(tracer)).film.mean();
                    let off = film.pixels.iter().map(|p| (p.y - 0.5).abs()).fold(0.0, f32::max);
                    assert!(off < 1e-5, "{on:?} {floor_first} {tracer:?}: {off}");
                }
            }
        }
    }
}

/// Of two coincident walls the first one wins, for camera rays and shadow rays.
#[test]
fn of_two_walls_in_one_place_the_first_is_there() {
    for place in places() {
        let at = |p: DVec3| place.transform_point3(p);
        let mut builder = seen(at(DVec3::new(0.03, 0.4, 0.02)), at(DVec3::ZERO), 0.01);
        let white = builder.material(matte(1.0, 0.0));
        let [first, second] = [0.8, 0.3].map(|color| builder.material(clear(1.0, true, color)));
        builder.mesh("floor", sheet(1.0, 0.0), place, white);
        builder.mesh("first", sheet(1.3, 0.5), place, first);
        builder.mesh("second", sheet(1.7, 0.5), place, second);
        builder.environment(Environment::constant(Vec3::ZERO));
        builder.distant_light(place.transform_vector3(DVec3::Y).normalize(), Vec3::splat(PI as f32));
        let scene = builder.build().unwrap();
        for tracer in [Tracer::Path, Tracer::Nested] {
            let film = run(&scene, &settings(tracer)).film.mean();
            let off = film.pixels.iter().map(|p| (p.y - 0.8).abs()).fold(0.0, f32::max);
            assert!(off < 1e-5, "{tracer:?}: {off}");
        }
    }
}

/// A lamp of area A just behind the face of a block: light that leaves the block spreads by its index, for which the
/// straight shadow ray is corrected. E = π·L·A·T/(n·h)²/π on the axis.
#[test]
fn transparent_shadows_know_that_light_spreads_where_it_leaves_glass() {
    let (n, h, depth, side, radiance) = (1.5f32, 1.0f32, 0.01f32, 0.02f32, 1000.0f32);
    let mut builder = seen(DVec3::new(0.03, 0.4, 0.02), DVec3::ZERO, 0.01);
    let white = builder.material(matte(1.0, 0.0));
    let glass = builder.material(clear(n, false, 1.0));
    let lamp = builder.material(matte(0.0, radiance));
    builder.mesh("floor", sheet(0.5, 0.0), DAffine3::IDENTITY, white);
    builder.mesh("glass", block(2.0), DAffine3::from_translation(DVec3::Y * f64::from(h)), glass);
    let down = quad(Vec3::new(-side, h + depth, -side), Vec3::X * 2.0 * side, Vec3::Z * 2.0 * side);
    builder.mesh("lamp", down, DAffine3::IDENTITY, lamp);
    builder.environment(Environment::constant(Vec3::ZERO));
    let scene = builder.build().unwrap();
    let reflected = ((n - 1.0) / (n + 1.0)).powi(2);
    let area = 4.0 * side * side;
    let exact = radiance * area * (1.0 - reflected) / (n * h + depth).powi(2) / PI as f32;
    for tracer in [Tracer::Path, Tracer::Nested] {
        let settings = Settings { transparent_shadows: true, max_bounces: 1, ..settings(tracer) };
        let film = run(&scene, &settings).film.mean();
        let seen = film.mean().y;
        assert!((seen / exact - 1.0).abs() < 2e-3, "{tracer:?}: {seen}, exact {exact}");
    }
}

/// Balls that touch each other from inside and outside on one axis, along which the camera looks: none of their media
/// is lost, wherever coordinates are rounded. All media are equal, so that the transmittance depends only on the length
/// inside.
#[test]
fn bodies_that_touch_keep_their_media() {
    let balls = [(3.0, 2.0), (0.5, 1.5), (3.0, 2.0), (-2.0, 2.0), (0.0, 2.0), (2.5, 0.5), (2.0, 2.0)];
    for (scale, offset) in
        [(1.0, DVec3::ZERO), (32.7, DVec3::new(83.3, -133.7, 87.2)), (0.7, DVec3::new(-9.1, 4.3, 300.1))]
    {
        let at = |z: f64| offset + DVec3::Z * (scale * z);
        let mut builder = seen_in_parallel(at(4.5), DVec3::NEG_Z, DVec3::Y, 0.002 * scale);
        let sigma = 0.1;
        for (i, (z, radius)) in balls.into_iter().enumerate() {
            let sigma_a = Vec3::splat((sigma / scale) as f32);
            let material = builder.material(TexturedMaterial { sigma_a, ..clear(1.3, false, 1.0) });
            builder.sphere(format!("ball {i}"), at(z), scale * radius, material);
        }
        builder.environment(Environment::constant(Vec3::ONE));
        let scene = builder.build().unwrap();
        // From 4.5 to −4, out into index 1; part of the light is reflected there.
        let most = (-sigma * 8.5).exp() * 1.69;
        let least = most * (1.0 - (0.3f64 / 2.3).powi(2));
        for tracer in [Tracer::Path, Tracer::Nested] {
            let settings = Settings { max_bounces: 64, ..settings(tracer) }.with_path(|p| p.roulette = false);
            let film = run(&scene, &settings).film.mean();
            let brightest = film.pixels.iter().map(|p| f64::from(p.y)).fold(0.0, f64::max);
            let mean = f64::from(film.mean().y);
            assert!(brightest < 1.001 * most, "{tracer:?}, {scale}: {brightest} of {most}");
            assert!((mean / least - 1.0).abs() < 0.02, "{tracer:?}, {scale}: {mean} of {least}");
        }
    }
}
