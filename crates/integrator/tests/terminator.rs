//! The soft shadow terminator: light passes over facets that approximate a curved surface, and nowhere else.

mod common;

use common::*;
use dapple_geometry::Mesh;
use dapple_imaging::Image;
use dapple_integrator::settings::MethodKind;
use dapple_integrator::{Outcome, Settings};
use dapple_lights::Environment;
use dapple_scene::{Scene, SceneBuilder};
use glam::{DAffine3, DVec3, Vec3};

fn soft(scene: &Scene, settings: &Settings) -> Outcome {
    run(scene, &Settings { soft_terminator: true, ..settings.clone() })
}

fn hard(scene: &Scene, settings: &Settings) -> Outcome {
    run(scene, &Settings { soft_terminator: false, ..settings.clone() })
}

fn both_methods(side: u32, spp: u32, max_bounces: u32) -> [Settings; 2] {
    [MethodKind::Path, MethodKind::Distribution].map(|method| {
        Settings { size: (side, side), max_bounces, ..Settings::default() }.with_method(method).with_spp(spp)
    })
}

/// An octahedron whose normals are those of the circumscribed sphere.
fn octahedron(r: f32) -> Mesh {
    let corners = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    Mesh {
        positions: corners.iter().map(|&p| p * r).collect(),
        normals: corners.to_vec(),
        triangles: vec![
            [0, 2, 4],
            [2, 1, 4],
            [1, 3, 4],
            [3, 0, 4],
            [2, 0, 5],
            [1, 2, 5],
            [3, 1, 5],
            [0, 3, 5],
        ],
        ..Mesh::default()
    }
}

/// Every facet with its own vertices, all of which have its normal.
fn flat_shaded(mesh: &Mesh) -> Mesh {
    let mut flat = Mesh::default();
    for t in 0..mesh.triangles.len() as u32 {
        let corners = mesh.corners(t);
        let first = flat.positions.len() as u32;
        flat.positions.extend(corners);
        let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        flat.normals.extend([n; 3]);
        flat.triangles.push([first, first + 1, first + 2]);
    }
    flat
}

fn beside_a_lamp(add: impl Fn(&mut SceneBuilder, u32) -> u32) -> Scene {
    let mut builder = seen(DVec3::new(0.0, 0.0, 6.0), DVec3::ZERO, 0.4);
    let grey = builder.material(matte(0.5, 0.0));
    add(&mut builder, grey);
    builder.point_light(DVec3::new(20.0, 5.0, 4.0), Vec3::splat(1e3), f64::INFINITY);
    builder.build().unwrap()
}

#[test]
fn flat_surfaces_spheres_and_disks_stay_as_they_are_to_the_bit() {
    let turned = DAffine3::from_rotation_x(0.3) * DAffine3::from_rotation_y(0.7);
    let mut without = octahedron(1.0);
    without.normals.clear();
    let flat = flat_shaded(&octahedron(1.0));
    let scenes = [
        beside_a_lamp(|b, grey| b.mesh("no normals", without.clone(), turned, grey)),
        beside_a_lamp(|b, grey| b.mesh("normals of the facets", flat.clone(), turned, grey)),
        beside_a_lamp(|b, grey| b.sphere("sphere", DVec3::ZERO, 1.0, grey)),
        beside_a_lamp(|b, grey| b.disk("disk", DVec3::ZERO, DVec3::new(0.9, 0.1, 0.3), 1.0, grey)),
    ];
    for (i, scene) in scenes.iter().enumerate() {
        for settings in both_methods(32, 16, 3) {
            let [a, b] = [soft(scene, &settings), hard(scene, &settings)].map(|o| o.film.mean());
            assert!(a.pixels.iter().any(|p| p.x > 0.0), "{i} is lit");
            assert_eq!(a.pixels, b.pixels, "{i} {:?}", settings.kind());
        }
    }
}

#[test]
fn light_reaches_what_the_facet_alone_would_hide() {
    let scene = beside_a_lamp(|b, grey| b.mesh("ball", octahedron(1.0), DAffine3::IDENTITY, grey));
    let round = beside_a_lamp(|b, grey| b.sphere("ball", DVec3::ZERO, 1.0, grey));
    for settings in both_methods(32, 64, 1) {
        let [a, b] = [soft(&scene, &settings), hard(&scene, &settings)].map(|o| o.film.mean());
        let exact = hard(&round, &settings).film.mean();
        let pairs = || a.pixels.iter().zip(&b.pixels);
        // At the rim, the horizon of the smooth surface can be above that of the facet.
        let gained = pairs().filter(|(a, b)| a.x > 0.0 && b.x == 0.0).count();
        let lost = pairs().filter(|(a, b)| a.x == 0.0 && b.x > 0.0).count();
        assert!(gained > 10 && 5 * lost < gained, "{gained}, {lost}, {:?}", settings.kind());
        let error = |of: &Image| {
            exact.pixels.iter().zip(&of.pixels).map(|(e, p)| f64::from((e.x - p.x).abs())).sum::<f64>()
        };
        assert!(error(&a) < 0.95 * error(&b), "nearer to the sphere: {} of {}", error(&a), error(&b));
        let brightest = exact.pixels.iter().map(|p| p.x).fold(0.0, f32::max);
        let added = pairs().map(|(a, b)| a.x - b.x).fold(0.0, f32::max);
        assert!(added < 0.7 * brightest, "grazing light only: {added} of {brightest}");
    }
}

/// In a white furnace a white body reflects 1, whatever directions its facets block: there is no gain, and a mirror has
/// no loss at its rim.
#[test]
fn a_furnace_stays_a_furnace() {
    for (name, material, least) in [("matte", matte(1.0, 0.0), 0.9), ("mirror", metal(Vec3::ONE, 0.0), 0.9)] {
        let mut builder = seen(DVec3::new(0.0, 0.0, 6.0), DVec3::ZERO, 0.4);
        let material = builder.material(material);
        builder.mesh("ball", octahedron(1.0), DAffine3::from_rotation_x(0.4), material);
        builder.environment(Environment::constant(Vec3::ONE));
        let scene = builder.build().unwrap();
        let settings = both_methods(48, 64, 60)[0].clone().with_path(|p| p.roulette = false);
        let [a, b] = [soft(&scene, &settings), hard(&scene, &settings)].map(|o| o.film.mean());
        let most = a.pixels.iter().map(|p| p.x).fold(0.0, f32::max);
        assert!(most <= 1.0 + 1e-5, "{name}: {most}");
        let mean = |pixels: &[Vec3]| pixels.iter().map(|p| f64::from(p.x)).sum::<f64>() / pixels.len() as f64;
        let (a, b) = (mean(&a.pixels), mean(&b.pixels));
        assert!(a > least && b > 0.9999, "{name}: {a}, without {b}");
    }
}

/// A rounded body half sunk into a floor with a lamp below: the smooth surface of its facets extends through the floor,
/// but light does not pass.
#[test]
fn nothing_leaks_through_a_floor_or_into_a_closed_body() {
    let mut builder = seen(DVec3::new(1.0, 1.5, 4.0), DVec3::new(0.0, 0.1, 0.0), 0.6);
    let grey = builder.material(matte(0.9, 0.0));
    builder.mesh("ball", octahedron(1.0), DAffine3::from_translation(DVec3::Y * 0.2), grey);
    let floor = quad(Vec3::new(-50.0, 0.0, -50.0), Vec3::Z * 100.0, Vec3::X * 100.0);
    builder.mesh("floor", floor, DAffine3::IDENTITY, grey);
    builder.point_light(DVec3::new(3.0, -0.3, 2.0), Vec3::splat(1e3), f64::INFINITY);
    let floor = builder.build().unwrap();
    let mut builder = seen(DVec3::ZERO, DVec3::new(0.3, 0.2, 1.0), 1.5);
    let grey = builder.material(matte(0.9, 0.0));
    builder.mesh("ball", octahedron(1.0), DAffine3::IDENTITY, grey);
    builder.point_light(DVec3::new(3.0, -1.0, 2.0), Vec3::splat(1e3), f64::INFINITY);
    builder.environment(Environment::constant(Vec3::ONE));
    let inside = builder.build().unwrap();
    for (name, scene) in [("floor", floor), ("inside", inside)] {
        for settings in both_methods(96, 64, 2) {
            // From inside, only back faces are in view.
            let settings = Settings { backfaces: dapple_integrator::Backfaces::Shown, ..settings };
            let lit = soft(&scene, &settings).film.mean().pixels.iter().filter(|p| p.x > 0.0).count();
            assert_eq!(lit, 0, "{name} {:?}", settings.kind());
        }
    }
}
