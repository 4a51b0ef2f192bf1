//! Emitters of every kind have the specified emission, with every strategy; other materials emit no light.

mod common;

use common::moving::{AT, SHUTTER, slide};
use common::*;
use dapple_imaging::Texture;
use dapple_imaging::read::Rgba8;
use dapple_imaging::texture::{Encoding, Interpolation, Sampler, Wrap};
use dapple_integrator::settings::Strategy;
use dapple_integrator::{MethodKind, Settings};
use dapple_lights::Environment;
use dapple_materials::Material;
use dapple_math::motion::Node;
use dapple_sampling::Pattern;
use dapple_scene::{AlphaMode, Scene, SceneBuilder, TextureUse, TexturedMaterial};
use dapple_testkit::{Rng, closed_form::polygon, z_test};
use glam::{DAffine3, DVec3, Vec2, Vec3};

const METHODS: [MethodKind; 2] = [MethodKind::Path, MethodKind::Distribution];

fn texture(
    width: usize,
    height: usize,
    sampler: Sampler,
    texel: impl Fn(usize, usize) -> [u8; 4],
) -> Texture {
    let texels = (0..width * height).map(|i| texel(i % width, i / width)).collect();
    Texture::new(Rgba8 { width, height, texels }, Encoding::Linear, sampler)
}

/// A square of side 1 at height `height` over the origin that faces down, with texture coordinates times `repeat`: u
/// along x, v along z.
fn panel(height: f32, repeat: f32) -> dapple_geometry::Mesh {
    let mut mesh = quad(Vec3::new(-0.5, height, -0.5), Vec3::X, Vec3::Z);
    mesh.uv[0] = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(|uv| uv * repeat).to_vec();
    mesh
}

fn emitting(texture: u32, radiance: f32) -> TexturedMaterial {
    let emissive_texture = Some(TextureUse::new(texture));
    TexturedMaterial { emissive_texture, ..TexturedMaterial::emitter("lamp", Vec3::splat(radiance)) }
}

/// A single lit texel of 300², anywhere, is sampled with low variance: the irradiance below it is that of its small
/// square.
#[test]
fn one_lit_texel_of_many() {
    let (n, mut rng) = (300, Rng::new(5));
    for case in 0..6 {
        let (x, y) = (rng.below(n) as usize, rng.below(n) as usize);
        let sampler = Sampler { interpolation: Interpolation::Nearest, ..Sampler::default() };
        let mut builder = irradiance_meter();
        let lit = builder.texture(texture(n as usize, n as usize, sampler, |i, j| {
            [if (i, j) == (x, y) { 255 } else { 0 }; 4]
        }));
        let lamp = builder.material(emitting(lit, 0.01));
        builder.mesh("lamp", panel(1.0, 1.0), DAffine3::IDENTITY, lamp);
        let scene = builder.build().unwrap();
        let corner = |i: usize, j: usize| {
            DVec3::new(i as f64, 0.0, j as f64) / f64::from(n) + DVec3::new(-0.5, 1.0, -0.5)
        };
        let corners = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        // The receiver faces +z in the closed form.
        let exact = 0.01 * polygon(&corners.map(|p| DVec3::new(p.x, -p.z, p.y))).abs();
        for method in METHODS {
            let settings = Settings { size: (8, 8), max_bounces: 1, ..Settings::default() }
                .with_method(method)
                .with_spp(64);
            let (mean, error) = mean_and_error(&run(&scene, &settings));
            let what = format!("case {case}, texel {x} {y}, {method:?}: {mean} ± {error}, exact {exact}");
            assert!(error < 0.02 * exact, "{what}");
            assert!((mean - exact).abs() < 4.0 * error + 1e-3 * exact, "{what}");
        }
    }
}

/// A floor without any other light, seen as a whole.
fn over_a_floor(roughness: Option<f32>) -> SceneBuilder {
    let mut builder = seen(DVec3::new(0.0, 0.9, 2.2), DVec3::new(0.0, 0.1, 0.0), 0.5);
    let floor = match roughness {
        None => matte(0.8, 0.0),
        Some(roughness) => metal(Vec3::splat(0.9), roughness),
    };
    let floor = builder.material(floor);
    let plane = quad(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::NEG_Z * 2.0);
    builder.mesh("floor", plane, DAffine3::IDENTITY, floor);
    builder.environment(Environment::constant(Vec3::ZERO));
    builder
}

/// Light sampling, BSDF sampling, and both give the same image, in both tracers.
fn strategies_agree(what: &str, scene: &Scene) {
    let strategies = [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly];
    let all: Vec<(f64, f64)> = METHODS
        .into_iter()
        .flat_map(|method| strategies.map(|strategy| (method, strategy)))
        .map(|(method, strategy)| {
            let mut settings = Settings {
                strategy,
                size: (16, 12),
                pattern: Pattern::Random,
                max_bounces: 1,
                ..Settings::default()
            }
            .with_method(method)
            .with_spp(300);
            for plan in [&mut settings.plans.light, &mut settings.plans.diffuse, &mut settings.plans.glossy] {
                (plan.nx, plan.ny, plan.pattern) = (4, 4, Pattern::Random);
            }
            (settings.plans.pixel.nx, settings.plans.pixel.ny) = (4, 4);
            let outcome = run(scene, &settings);
            assert_eq!(outcome.stats.bad_sample_count, 0);
            sums(&outcome)
        })
        .collect();
    let level = z_test::sidak(1e-3, all.len() * 8);
    for (i, a) in all.iter().enumerate() {
        for b in &all[..i] {
            let z = (a.0 - b.0) / (a.1.powi(2) + b.1.powi(2)).sqrt();
            assert!(z_test::two_sided(z) > level, "{what}: {all:?}");
        }
    }
    assert!(all[0].1 < 0.05 * all[0].0, "{what}: {all:?} are inconclusive");
}

/// Mean over the image, and its standard error from the sample variances.
fn sums(outcome: &dapple_integrator::Outcome) -> (f64, f64) {
    let mean = outcome.film.mean();
    let n = mean.pixels.len() as f64;
    let value = mean.pixels.iter().map(|p| f64::from(p.element_sum()) / 3.0).sum::<f64>() / n;
    let variances: f64 =
        outcome.film.variance().pixels.iter().map(|v| f64::from(v.element_sum()) / 3.0).sum();
    (value, (variances / (n * n)).sqrt())
}

#[test]
fn textured_panels_by_every_strategy() {
    let mut rng = Rng::new(9);
    let noise: Vec<u8> = (0..64).map(|_| if rng.f64() < 0.3 { rng.below(256) as u8 } else { 0 }).collect();
    for (height, wrap, interpolation, repeat) in [
        (0.7, Wrap::Repeat, Interpolation::Linear, 2.3),
        (0.1, Wrap::Mirror, Interpolation::Nearest, 1.7),
        (0.02, Wrap::Clamp, Interpolation::Linear, 1.4),
    ] {
        for roughness in [None, Some(0.4)] {
            let mut builder = over_a_floor(roughness);
            let sampler = Sampler { wrap_s: wrap, wrap_t: wrap, interpolation };
            let spots = builder.texture(texture(8, 8, sampler, |x, y| [noise[8 * y + x]; 4]));
            let lamp = builder.material(emitting(spots, 3.0));
            builder.mesh("lamp", panel(height, repeat), DAffine3::IDENTITY, lamp);
            let what = format!("at {height}, {wrap:?} {interpolation:?}, floor {roughness:?}");
            strategies_agree(&what, &builder.build().unwrap());
        }
    }
}

/// Holes by MASK and by BLEND, with varying colour.
#[test]
fn panels_with_holes_by_every_strategy() {
    for alpha_mode in [AlphaMode::Mask { cutoff: 0.6 }, AlphaMode::Blend] {
        let mut builder = over_a_floor(None);
        let sampler = Sampler { wrap_s: Wrap::Clamp, wrap_t: Wrap::Clamp, ..Sampler::default() };
        let holes = builder
            .texture(texture(5, 5, sampler, |x, y| [255, 255, 255, if (x, y) == (3, 1) { 255 } else { 0 }]));
        let colour =
            builder.texture(texture(2, 1, sampler, |x, _| [[255, 30, 0, 255], [0, 60, 200, 255]][x]));
        let base_color_texture = Some(TextureUse::new(holes));
        let lamp = TexturedMaterial { base_color_texture, alpha_mode, ..emitting(colour, 8.0) };
        let lamp = builder.material(lamp);
        builder.mesh("lamp", panel(0.4, 1.0), DAffine3::IDENTITY, lamp);
        strategies_agree(&format!("{alpha_mode:?}"), &builder.build().unwrap());
    }
}

/// Exact spheres and disks evaluate their texture at the emitting point.
#[test]
fn textured_shapes_by_every_strategy() {
    for disk in [false, true] {
        let mut builder = over_a_floor(None);
        let stripes = builder
            .texture(texture(4, 4, Sampler::default(), |x, y| [if (x + y) % 3 == 1 { 255 } else { 0 }; 4]));
        let lamp = builder.material(emitting(stripes, 5.0));
        match disk {
            false => builder.sphere("lamp", DVec3::new(0.1, 0.5, 0.0), 0.3, lamp),
            true => builder.disk("lamp", DVec3::new(0.1, 0.5, 0.0), DVec3::new(0.2, -1.0, 0.1), 0.4, lamp),
        };
        strategies_agree(&format!("disk {disk}"), &builder.build().unwrap());
    }
}

/// A sphere and a disk that are stretched non-uniformly while they move, and a textured panel that moves and is
/// mirrored.
#[test]
fn moving_emitters_by_every_strategy() {
    for which in 0..3 {
        let mut builder = over_a_floor(None);
        builder.exposure(AT, SHUTTER);
        let mut chain = slide(DVec3::new(-0.3, 0.5, 0.0), DVec3::new(0.3, 0.5, 0.0));
        let uneven = DAffine3::from_rotation_z(0.4) * DAffine3::from_scale(DVec3::new(1.5, 0.3, 0.8));
        match which {
            0 => {
                chain.push(Node::Fixed(uneven));
                let lamp = builder.material(matte(0.0, 2.0));
                builder.moving_sphere("oval", 0.3, chain, lamp);
            }
            1 => {
                chain.push(Node::Fixed(DAffine3::from_rotation_x(1.4) * uneven));
                let lamp = builder.material(matte(0.0, 2.0));
                builder.moving_disk("oval", 0.4, chain, lamp);
            }
            _ => {
                chain.push(Node::Fixed(DAffine3::from_scale(DVec3::new(-0.8, 0.7, 1.0))));
                let sampler = Sampler { interpolation: Interpolation::Nearest, ..Sampler::default() };
                let lit = builder.texture(texture(6, 6, sampler, |x, y| {
                    [if (x, y) == (1, 4) || x == 3 { 255 } else { 0 }; 4]
                }));
                let lamp = builder.material(emitting(lit, 5.0));
                builder.moving_mesh("panel", panel(0.0, 1.0), chain, lamp);
            }
        }
        strategies_agree(&format!("moving {which}"), &builder.build().unwrap());
    }
}

fn unlit(color: f32) -> TexturedMaterial {
    TexturedMaterial { unlit: true, ..matte(color, 0.0) }
}

/// Diffuse, glossy and, seen in a mirror, diffuse again: black, bit for bit.
#[test]
fn shadeless_surfaces_light_nothing() {
    for roughness in [None, Some(0.3), Some(1.0)] {
        for by_mirror in [false, true] {
            let mut builder = over_a_floor(roughness);
            let panel_of = builder.material(unlit(0.7));
            // Behind the camera; the mirror faces both.
            builder.mesh("panel", panel(1.6, 1.0), DAffine3::IDENTITY, panel_of);
            if by_mirror {
                let mirror = builder.material(metal(Vec3::ONE, 0.0));
                let plane = quad(Vec3::new(3.0, 0.0, -1.0), Vec3::Z * 2.0, Vec3::Y * 2.0);
                builder.mesh("mirror", plane, DAffine3::IDENTITY, mirror);
            }
            let scene = builder.build().unwrap();
            for method in METHODS {
                let settings = Settings { size: (24, 8), max_bounces: 4, ..Settings::default() }
                    .with_method(method)
                    .with_spp(16);
                let (mean, _) = mean_and_error(&run(&scene, &settings));
                assert_eq!(mean, 0.0, "{roughness:?}, mirror {by_mirror}, {method:?}");
            }
        }
    }
}

/// Directly, in a mirror, and through clear glass.
#[test]
fn shadeless_surfaces_are_seen() {
    let glass = Material {
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        ior: 1.0,
        thin: true,
        ..Material::default()
    };
    for which in 0..3 {
        let mut builder = seen(DVec3::Z, DVec3::ZERO, 0.2);
        builder.environment(Environment::constant(Vec3::ZERO));
        let panel_of = builder.material(unlit(0.7));
        let wide = |z: f32| quad(Vec3::new(-9.0, -9.0, z), Vec3::X * 18.0, Vec3::Y * 18.0);
        builder.mesh("panel", wide(if which == 1 { 3.0 } else { -1.0 }), DAffine3::IDENTITY, panel_of);
        if which > 0 {
            let clear = TexturedMaterial { base: glass, ..TexturedMaterial::default() };
            let between = builder.material(if which == 1 { metal(Vec3::ONE, 0.0) } else { clear });
            builder.mesh("between", wide(0.0), DAffine3::IDENTITY, between);
        }
        let scene = builder.build().unwrap();
        for method in METHODS {
            let settings = Settings { size: (4, 4), max_bounces: 3, ..Settings::default() }
                .with_method(method)
                .with_spp(16);
            let (mean, _) = mean_and_error(&run(&scene, &settings));
            assert!((mean - 0.7).abs() < 1e-5, "case {which}, {method:?}: {mean}");
        }
    }
}
