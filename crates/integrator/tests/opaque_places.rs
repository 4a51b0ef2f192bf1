//! Two coincident opaque surfaces that do not emit light: the lower object index wins, independently of rounding.

mod common;

use common::tracers::{Tracer, one_pixel};
use common::{blurred_mirror, matte, quad, run, seen};
use dapple_geometry::Mesh;
use dapple_integrator::{Aov, Backfaces, Effect, Settings};
use dapple_lights::Environment;
use dapple_materials::Material;
use dapple_sampling::Pattern;
use dapple_scene::{Scene, SceneBuilder, TexturedMaterial};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

const RED: Vec3 = Vec3::new(0.8, 0.1, 0.05);
const GREEN: Vec3 = Vec3::new(0.1, 0.6, 0.2);

fn painted(color: Vec3, double_sided: bool) -> TexturedMaterial {
    let of = matte(0.0, 0.0);
    TexturedMaterial { base: Material { base_color: color, ..of.base }, double_sided, ..of }
}

/// A horizontal square at y = 0 of half side `r`, which faces up or down.
fn sheet(r: f32, up: bool) -> Mesh {
    let side = if up { 1.0 } else { -1.0 };
    quad(Vec3::new(-r, 0.0, r * side), Vec3::X * 2.1 * r, Vec3::Z * -2.2 * r * side)
}

/// Positions at which coordinates round differently.
fn places() -> [DAffine3; 4] {
    let turn = |axis: DVec3, angle| DQuat::from_axis_angle(axis.normalize(), angle);
    let (tilted, small) = (turn(DVec3::new(1.0, 2.0, 3.0), 1.1), turn(DVec3::new(-2.0, 1.0, 0.5), 2.3));
    let placed = DAffine3::from_scale_rotation_translation;
    [
        DAffine3::IDENTITY,
        placed(DVec3::ONE, tilted, DVec3::new(7.0, -3.0, 11.0)),
        placed(DVec3::splat(0.01), small, DVec3::new(0.3, 40.0, -0.7)),
        placed(DVec3::new(-1.0, 1.0, 1.0), tilted, DVec3::new(0.1, 0.2, 0.3)),
    ]
}

/// A builder with a camera that looks at the middle of the sheets from above or below.
fn view(place: DAffine3, y: f64) -> SceneBuilder {
    let at = |p: DVec3| place.transform_point3(p);
    let mut builder = seen(at(DVec3::new(0.3, 4.0 * y, 0.2)), at(DVec3::new(0.07, 0.0, 0.03)), 0.2);
    builder.environment(Environment::constant(Vec3::ZERO));
    builder
}

/// A distant light straight above or below, of irradiance π: diffuse surfaces show their albedo.
fn shone_on(mut builder: SceneBuilder, place: DAffine3, y: f64) -> Scene {
    builder.distant_light(place.transform_vector3(DVec3::Y * y).normalize(), Vec3::splat(PI as f32));
    builder.build().unwrap()
}

/// Two sheets, in this order; instances of one mesh stay in its space.
fn put_sheets(builder: &mut SceneBuilder, place: DAffine3, colors: &[Vec3], instances: bool) {
    let shared = Arc::new(sheet(1.7, true));
    let turned = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.9),
        DQuat::from_rotation_y(0.3),
        DVec3::ZERO,
    );
    for ((color, r), turn) in colors.iter().zip([1.9, 1.3]).zip([DAffine3::IDENTITY, turned]) {
        let material = builder.material(painted(*color, false));
        match instances {
            true => builder.mesh("sheet", shared.clone(), place * turn, material),
            false => builder.mesh("sheet", sheet(r, true), place, material),
        };
    }
}

fn settings(tracer: Tracer) -> Settings {
    let integrals = &[(Effect::Light, [1, 1]), (Effect::Diffuse, [4, 4])];
    Settings { size: (16, 16), max_bounces: 4, ..one_pixel(tracer, Pattern::Random, integrals, 16) }
}

#[track_caller]
fn assert_shows(what: &str, scene: &Scene, settings: &Settings, color: Vec3) {
    let film = run(scene, settings).film.mean();
    let off = film.pixels.iter().map(|p| (*p - color).abs().max_element()).fold(0.0, f32::max);
    assert!(off < 1e-5, "{what}: {off} off");
}

const BOTH: [Tracer; 2] = [Tracer::Path, Tracer::Nested];

#[test]
fn of_two_opaque_surfaces_in_one_place_the_lower_object_is_seen() {
    for place in places() {
        for colors in [[RED, GREEN], [GREEN, RED]] {
            for instances in [false, true] {
                let mut builder = view(place, 1.0);
                put_sheets(&mut builder, place, &colors, instances);
                let scene = shone_on(builder, place, 1.0);
                for tracer in BOTH {
                    let what = format!("{tracer:?}, {instances}, {place:?}");
                    assert_shows(&what, &scene, &settings(tracer), colors[0]);
                    let settings = Settings { aovs: vec![Aov::ObjectId], ..settings(tracer) };
                    let outcome = run(&scene, &settings);
                    let layer = outcome.layers.layer("object").unwrap();
                    let ids: Vec<f32> = layer.channels.iter().flat_map(|c| c.1.clone()).collect();
                    assert!(ids.iter().all(|id| *id == ids[0]), "{what}: {ids:?}");
                }
            }
        }
    }
}

/// A mirror, or a diffuse ceiling lit only by the sheets, above them; the camera looks up at it.
fn reflected(place: DAffine3, colors: &[Vec3], over: &TexturedMaterial) -> Scene {
    let at = |p: DVec3| place.transform_point3(p);
    let mut builder = seen(at(DVec3::new(0.3, 0.4, 0.2)), at(DVec3::new(0.07, 2.0, 0.03)), 0.2);
    builder.environment(Environment::constant(Vec3::ZERO));
    put_sheets(&mut builder, place, colors, false);
    let over = builder.material(over.clone());
    builder.mesh("over", sheet(0.6, false), place * DAffine3::from_translation(DVec3::Y * 2.0), over);
    // At an angle, so that the surfaces above do not shadow the part of the sheets that the camera sees.
    let sun = place.transform_vector3(DVec3::new(1.0, 0.5, 0.0)).normalize();
    builder.distant_light(sun, Vec3::splat(PI as f32));
    builder.build().unwrap()
}

/// The result equals that with the lower sheet alone.
#[test]
fn light_that_was_scattered_meets_the_lower_object_too() {
    for place in places() {
        for colors in [[RED, GREEN], [GREEN, RED]] {
            for over in [blurred_mirror(0.0), painted(Vec3::ONE, false)] {
                let [both, alone] = [&colors[..], &colors[..1]].map(|c| reflected(place, c, &over));
                for tracer in BOTH {
                    let integrals =
                        &[(Effect::Light, [1, 1]), (Effect::Glossy, [1, 1]), (Effect::Diffuse, [4, 4])];
                    let settings = Settings {
                        size: (8, 8),
                        max_bounces: 2,
                        ..one_pixel(tracer, Pattern::Random, integrals, 16)
                    };
                    let [seen, exact] = [&both, &alone].map(|scene| run(scene, &settings).film.mean().pixels);
                    assert!(exact.iter().any(|p| p.max_element() > 0.05), "{tracer:?}: dark");
                    let off = seen.iter().zip(&exact).map(|(p, q)| (*p - *q).abs().max_element());
                    let most = off.fold(0.0, f32::max);
                    assert!(most < 1e-4, "{tracer:?}, {place:?}: {most} off");
                }
            }
        }
    }
}

/// The faces of a wall, one for each side.
#[test]
fn of_a_wall_of_two_single_sided_faces_each_side_shows_its_own() {
    for place in places() {
        for (y, first_up) in [(1.0, true), (1.0, false), (-1.0, true), (-1.0, false)] {
            let mut builder = view(place, y);
            for (up, r) in [(first_up, 1.9), (!first_up, 1.3)] {
                let material = builder.material(painted(if up { RED } else { GREEN }, false));
                builder.mesh("face", sheet(r, up), place, material);
            }
            let scene = shone_on(builder, place, y);
            for tracer in BOTH {
                let settings = Settings { backfaces: Backfaces::Camera, ..settings(tracer) };
                let what = format!("{tracer:?}, {y}, {first_up}, {place:?}");
                assert_shows(&what, &scene, &settings, if y > 0.0 { RED } else { GREEN });
            }
        }
    }
}
