//! Batches of samples give the same bits as single samples, with every instruction set and every size of batch.

mod common;

use common::*;
use dapple_integrator::camera::Clip;
use dapple_integrator::math::PixelRect;
use dapple_integrator::math::lanes::Isa;
use dapple_integrator::settings::Strategy;
use dapple_integrator::{Aov, Backfaces, Outcome, Settings, render};
use dapple_materials::{Material, Mirror};
use dapple_sampling::Pattern;
use dapple_scene::{AlphaMode, Scene, SceneBuilder, TexturedMaterial, WorldPoint};
use glam::{DAffine3, DVec3, Vec3};
use std::ops::ControlFlow;

/// The scenes of the project, those without batches included.
#[cfg(feature = "gltf")]
fn scenes() -> Vec<Scene> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries.filter(|path| path.extension().is_some_and(|e| e == "gltf")).collect();
    files.sort();
    assert!(files.len() > 8, "{files:?}");
    let options = dapple_scene::gltf::Options::default();
    files.iter().map(|file| dapple_scene::gltf::read(file, &options).unwrap().build().unwrap()).collect()
}

fn settings() -> Settings {
    Settings { size: (20, 18), seed: 5, aovs: vec![Aov::Removed], ..Settings::default() }
}

fn rendered(scene: &Scene, settings: &Settings, batch: u32, isa: Isa, threads: usize) -> Outcome {
    let mut settings = settings.clone().with_threads(threads);
    (settings.limits.batch, settings.limits.isa) = (Some(batch), Some(isa));
    render(scene, &scene.cameras[0].camera, &settings, &|_| ControlFlow::Continue(()))
}

fn is_same(a: &Outcome, b: &Outcome) -> bool {
    a.film == b.film
        && a.layers == b.layers
        && a.tail.sorted() == b.tail.sorted()
        && (a.stats.rays, a.stats.samples, a.stats.bias) == (b.stats.rays, b.stats.samples, b.stats.bias)
        && (&a.stats.bad_samples, a.stats.bad_sample_count)
            == (&b.stats.bad_samples, b.stats.bad_sample_count)
}

/// Compares all lanes and several sizes of batches with single samples.
fn check(scene: &Scene, settings: &Settings) {
    let single = rendered(scene, settings, 0, Isa::Portable, 1);
    for isa in Isa::available() {
        for (batch, threads) in [(1024, 1), (64, 2), (7, 1), (1, 2)] {
            let many = rendered(scene, settings, batch, isa, threads);
            assert!(
                is_same(&many, &single),
                "{} {isa:?} {batch}: {:?} {:?}",
                scene.name,
                many.stats,
                single.stats
            );
        }
    }
}

#[cfg(feature = "gltf")]
#[test]
fn every_scene_has_the_bits_of_single_samples() {
    for scene in scenes() {
        check(&scene, &settings().with_spp(5));
    }
}

/// Paths go on one by one where a surface emits light; there, normal maps and interpolated normals apply as elsewhere.
#[cfg(feature = "gltf")]
#[test]
fn surfaces_that_emit_light_have_the_bits_of_single_samples() {
    for mut scene in scenes().into_iter().chain([outdoors()]) {
        scene.materials.iter_mut().for_each(|material| material.emission = Vec3::new(0.1, 0.2, 0.3));
        check(&scene, &settings().with_spp(3));
    }
}

#[test]
fn environment_maps_and_smooth_bodies_have_the_bits_of_single_samples() {
    let scene = outdoors();
    check(&scene, &settings().with_spp(16));
    for strategy in [Strategy::BsdfOnly, Strategy::LightOnly] {
        check(&scene, &Settings { strategy, ..settings() });
    }
    check(&scene, &Settings { max_bounces: 1, soft_terminator: false, ..settings() });
}

/// A room with lights and surfaces of all kinds that batches treat differently: coated, metallic and diffuse materials,
/// a mirror, smooth normals that lean, lights of several kinds.
fn room() -> Scene {
    let mut builder: SceneBuilder = seen(DVec3::new(0.0, 1.5, 6.0), DVec3::new(0.0, 0.8, 0.0), 0.8);
    let plastic = Material { metallic: 0.0, roughness: 0.3, ..Material::default() };
    let mirror = Some(Mirror { kr: Vec3::splat(0.8), blur: 0.1 });
    let sheet =
        Material { transmission: 0.7, thin: true, roughness: 0.4, metallic: 0.0, ..Material::default() };
    let bases = [
        plastic,
        Material { mirror, ..plastic },
        Material { roughness: 0.0, ..plastic },
        Material { roughness: 0.6, ..Material::default() },
        sheet,
    ];
    let floor = builder.material(matte(0.6, 0.0));
    let ground = quad(Vec3::new(-6.0, 0.0, 6.0), Vec3::X * 12.0, Vec3::Z * -12.0);
    builder.mesh("floor", ground, DAffine3::IDENTITY, floor);
    for (i, base) in bases.into_iter().enumerate() {
        let material = builder.material(TexturedMaterial { base, ..TexturedMaterial::default() });
        let x = i as f32 * 1.1 - 2.8;
        let wall = quad(Vec3::new(x, 0.0, -0.3 * i as f32), Vec3::X, Vec3::new(0.0, 1.4, -0.4));
        builder.mesh("wall", wall, DAffine3::IDENTITY, material);
        builder.sphere("ball", DVec3::new(f64::from(x) + 0.5, 0.4, 1.0), 0.35, material);
    }
    let lamp = builder.material(matte(0.0, 5.0));
    let panel = quad(Vec3::new(-1.0, 3.5, -1.0), Vec3::X * 2.0, Vec3::Z * 1.5);
    builder.mesh("panel", panel, DAffine3::IDENTITY, lamp);
    builder.sphere("bulb", DVec3::new(2.0, 2.5, 0.5), 0.2, lamp);
    builder.build().unwrap()
}

#[test]
fn every_setting_has_the_bits_of_single_samples() {
    let scene = room();
    check(&scene, &settings().with_spp(9));
    for pattern in [Pattern::Random, Pattern::Stratified, Pattern::Grid] {
        check(&scene, &Settings { pattern, ..settings().with_spp(6) });
    }
    for strategy in [Strategy::LightOnly, Strategy::BsdfOnly] {
        check(&scene, &Settings { strategy, ..settings().with_spp(4) });
    }
    let crop = Some(PixelRect { x0: 3, y0: 2, x1: 19, y1: 11 });
    check(&scene, &Settings { crop, clamp: Some(0.5), ..settings().with_spp(4) });
    for bounces in [0, 1, 3u32] {
        check(&scene, &Settings { max_bounces: bounces, ..settings().with_spp(3) });
    }
    check(&scene, &settings().with_spp(3).with_path(|path| path.roulette = false));
    check(&scene, &settings().with_spp(24).with_path(|path| path.adaptive = true));
}

/// A room of what paths pass: glass with a bubble in it, a body around the camera's side, thin panes one behind the
/// other, surfaces with holes and half-transparent ones, single-sided walls.
fn clear_room(has_alpha: bool) -> Scene {
    let mut builder: SceneBuilder = seen(DVec3::new(0.0, 1.5, 6.0), DVec3::new(0.0, 0.8, 0.0), 0.8);
    let floor = builder.material(matte(0.6, 0.0));
    let ground = quad(Vec3::new(-6.0, 0.0, 6.0), Vec3::X * 12.0, Vec3::Z * -12.0);
    builder.mesh("floor", ground, DAffine3::IDENTITY, floor);
    let mut glass = clear(0.0, 1.5);
    glass.sigma_a = Vec3::new(0.1, 0.4, 0.2);
    let (tinted, rough, air) =
        (builder.material(glass), builder.material(clear(0.2, 1.3)), pane(1.0, false, Vec3::ONE));
    let bubble = builder.material(TexturedMaterial { priority: 1.0, ..air });
    builder.sphere("glass", DVec3::new(-1.0, 0.9, 0.5), 0.8, tinted);
    builder.sphere("bubble", DVec3::new(-1.0, 1.0, 0.7), 0.3, bubble);
    builder.sphere("rough", DVec3::new(1.6, 0.6, 1.0), 0.5, rough);
    let window = builder.material(pane(1.5, true, Vec3::new(0.9, 0.7, 0.8)));
    for z in [1.8f32, 2.2, 2.6] {
        let sheet = quad(Vec3::new(-0.4, 0.1, z), Vec3::X * 1.6, Vec3::Y * 1.2);
        builder.mesh("pane", sheet, DAffine3::IDENTITY, window);
    }
    if has_alpha {
        let modes = [AlphaMode::Mask { cutoff: 0.7 }, AlphaMode::Mask { cutoff: 0.2 }, AlphaMode::Blend];
        for (i, alpha_mode) in modes.into_iter().enumerate() {
            let veil = builder.material(TexturedMaterial { alpha: 0.5, alpha_mode, ..matte(0.8, 0.0) });
            let sheet = quad(Vec3::new(i as f32 - 2.0, 0.3, 1.2), Vec3::X * 0.9, Vec3::new(0.0, 1.0, 0.5));
            builder.mesh("veil", sheet, DAffine3::IDENTITY, veil);
        }
    }
    let lamp = builder.material(matte(0.0, 5.0));
    let panel = quad(Vec3::new(-1.0, 3.5, -1.0), Vec3::X * 2.0, Vec3::Z * 1.5);
    builder.mesh("panel", panel, DAffine3::IDENTITY, lamp);
    builder.sphere("bulb", DVec3::new(2.0, 2.5, 0.5), 0.2, lamp);
    builder.point_light(DVec3::new(-2.0, 2.0, 3.0), Vec3::splat(4.0), f64::INFINITY);
    let scene = builder.build().unwrap();
    // Scenes with coincident surfaces have no batches.
    assert!(scene.shared_places.is_none());
    scene
}

#[test]
fn glass_panes_and_holes_have_the_bits_of_single_samples() {
    for has_alpha in [false, true] {
        let scene = clear_room(has_alpha);
        check(&scene, &settings().with_spp(9));
        check(&scene, &Settings { transparent_shadows: true, ..settings().with_spp(5) });
        check(&scene, &Settings { backfaces: Backfaces::Culled, ..settings().with_spp(4) });
        check(&scene, &Settings { backfaces: Backfaces::Shown, max_bounces: 2, ..settings().with_spp(4) });
        check(&scene, &Settings { strategy: Strategy::BsdfOnly, ..settings().with_spp(4) });
    }
}

#[test]
fn first_hits_have_the_bits_of_single_samples() {
    let aovs: Vec<Aov> = Aov::ALL.iter().map(|(aov, _)| *aov).collect();
    for scene in [room(), clear_room(false), clear_room(true)] {
        check(&scene, &Settings { aovs: aovs.clone(), ..settings().with_spp(6) });
        check(&scene, &Settings { transparent: true, ..settings().with_spp(4) });
        check(&scene, &Settings { aovs: vec![Aov::Albedo], picture: false, ..settings().with_spp(3) });
    }
}

/// The camera is inside a body, and near and far planes cut the scene.
#[test]
fn cameras_in_bodies_have_the_bits_of_single_samples() {
    let mut scene = clear_room(true);
    let settings = settings().with_spp(5);
    scene.cameras[0].camera.origin = scene.space.to_render(WorldPoint(DVec3::new(-1.0, 0.3, 0.7)));
    check(&scene, &settings);
    scene.cameras[0].camera.origin = scene.space.to_render(WorldPoint(DVec3::new(0.0, 1.5, 6.0)));
    let clip = [3.9, 7.0].map(|distance| scene.space.length_to_render(distance));
    scene.cameras[0].camera.clip = Some(Clip { near: clip[0], far: clip[1] });
    check(&scene, &settings);
}
