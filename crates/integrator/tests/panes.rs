//! Clear panes: light passes straight through thin walls and boundaries between equal indices, in both tracers; the
//! light that this omits is in the bias report.

mod common;

use common::tracers::{Tracer, one_pixel};
use common::{irradiance_meter, matte, metal, pane, quad};
use dapple_geometry::bvh::Kernel;
use dapple_imaging::Image;
use dapple_integrator::{Effect, Outcome, Settings, render};
use dapple_lights::Environment;
use dapple_materials::Material;
use dapple_sampling::Pattern;
use dapple_scene::{Scene, SceneBuilder, TexturedMaterial};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::PI;
use std::ops::ControlFlow;

fn absorbing(material: TexturedMaterial, sigma: f32) -> TexturedMaterial {
    TexturedMaterial { sigma_a: Vec3::splat(sigma), ..material }
}

/// A horizontal square of half side `r` that faces up.
fn sheet(r: f32, y: f32) -> dapple_geometry::Mesh {
    quad(Vec3::new(-r, y, r), Vec3::X * 2.0 * r, Vec3::Z * -2.0 * r)
}

/// A closed slab of half side `r` from y = a to y = b, above the floor and its camera.
fn slab(r: f32, a: f32, b: f32) -> dapple_geometry::Mesh {
    let at = |i: u32| {
        Vec3::new(
            if i & 1 == 1 { r } else { -r },
            if i & 2 == 2 { b } else { a },
            if i & 4 == 4 { r } else { -r },
        )
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    dapple_geometry::Mesh {
        positions: (0..8).map(at).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        ..dapple_geometry::Mesh::default()
    }
}

fn run(scene: &Scene, settings: &Settings) -> Outcome {
    let outcome = render(scene, &scene.cameras[0].camera, settings, &|_| ControlFlow::Continue(()));
    assert_eq!(outcome.stats.bad_sample_count, 0);
    outcome
}

/// A white floor under black surroundings, with additional objects.
fn floor(add: impl Fn(&mut SceneBuilder)) -> Scene {
    let mut builder = irradiance_meter();
    builder.environment(Environment::constant(Vec3::ZERO));
    add(&mut builder);
    builder.build().unwrap()
}

/// Asserts the irradiance on the floor from punctual lights, in both tracers.
#[track_caller]
fn assert_lit(what: &str, scene: &Scene, exact: Vec3, more: &Settings) -> [Outcome; 2] {
    [Tracer::Path, Tracer::Nested].map(|tracer| {
        let settings = Settings {
            transparent_shadows: more.transparent_shadows,
            ..one_pixel(tracer, Pattern::Random, &[], 4)
        };
        let outcome = run(scene, &settings);
        let seen = outcome.film.mean().pixels[0] * PI as f32;
        let off = (seen - exact).abs().max_element();
        assert!(off <= 2e-5 * exact.max_element().max(1e-2), "{what}, {tracer:?}: {seen}, exact {exact}");
        outcome
    })
}

/// Reflectance of one face for light arriving at the cosine `c` from outside.
fn fresnel(c: f64, eta: f64) -> f64 {
    let ct = (1.0 - (1.0 - c * c) / (eta * eta)).sqrt();
    let (s, p) = ((c - eta * ct) / (c + eta * ct), (eta * c - ct) / (eta * c + ct));
    0.5 * (s * s + p * p)
}

/// Reflectance of a thin wall, including all interreflections between its faces.
fn wall(c: f64, eta: f64) -> f64 {
    let r = fresnel(c, eta);
    1.0 - 2.0 * r / (1.0 + r)
}

const TINT: Vec3 = Vec3::new(0.9, 0.5, 0.1);

#[test]
fn suns_and_points_shine_through_thin_walls_with_their_transmittance() {
    for (ior, panes) in [(1.0f32, 1), (1.5, 1), (1.5, 3), (2.4, 2)] {
        let towards = DVec3::new(0.9, 1.0, -0.4).normalize();
        let each = wall(towards.y, f64::from(ior));
        let exact = (TINT * each as f32).powf(panes as f32) * (towards.y * 3.0) as f32;
        let point = DVec3::new(0.9, 3.0, -0.6);
        let exact_point = {
            let (d2, c) = (point.length_squared(), point.normalize().y);
            (TINT * wall(c, f64::from(ior)) as f32).powf(panes as f32) * (c * 7.0 / d2) as f32
        };
        for is_sun in [true, false] {
            let scene = floor(|builder| {
                let glass = builder.material(pane(ior, true, TINT));
                for i in 0..panes {
                    builder.mesh("pane", sheet(30.0, 1.0 + 0.1 * i as f32), DAffine3::IDENTITY, glass);
                }
                if is_sun {
                    builder.distant_light(towards, Vec3::splat(3.0));
                } else {
                    builder.point_light(point, Vec3::splat(7.0), f64::INFINITY);
                }
            });
            let what = format!("{ior}, {panes} panes, sun {is_sun}");
            let outcomes =
                assert_lit(&what, &scene, if is_sun { exact } else { exact_point }, &Settings::default());
            // A reflecting wall sends light to places where no strategy finds it.
            let left_out = u64::from(ior > 1.0);
            assert!(outcomes.iter().all(|o| o.stats.bias.lights_unreachable == left_out), "{what}");
        }
    }
}

#[test]
fn lights_shine_into_through_and_out_of_index_matched_bodies() {
    let lamp = DVec3::new(0.0, 2.0, 0.0);
    let (intensity, sigma) = (5.0f32, 0.7f32);
    // The length within absorbing matter on the segment from floor to lamp.
    for (what, a, b, hollow, way) in [
        ("through", 1.0, 1.5, None, 0.5),
        ("out of it", 1.5, 2.5, None, 0.5),
        ("all inside", -1.0, 2.5, None, 2.0),
        ("into it", -1.0, 1.0, None, 1.0),
        ("hollow", -1.0, 2.5, Some((0.9, 1.4)), 1.5),
        ("from a hollow", -1.0, 2.5, Some((1.2, 2.2)), 1.2),
    ] {
        let scene = floor(|builder| {
            let dark = builder.material(absorbing(pane(1.0, false, Vec3::ONE), sigma));
            let clear = builder.material(pane(1.0, false, Vec3::ONE));
            builder.mesh("body", slab(3.0, a, b), DAffine3::IDENTITY, dark);
            if let Some((a, b)) = hollow {
                builder.mesh("hollow", slab(2.0, a, b), DAffine3::IDENTITY, clear);
            }
            builder.point_light(lamp, Vec3::splat(intensity), f64::INFINITY);
        });
        // The camera looks from a height of 0.8 along a segment of this length, part of which absorbs.
        let seen = DVec3::new(0.3, 0.8, 0.2).length() as f32 * if a < 0.0 { 1.0 } else { 0.0 };
        let exact = Vec3::splat(intensity / 4.0 * (-sigma * (way + seen)).exp());
        let outcomes = assert_lit(what, &scene, exact, &Settings::default());
        assert!(outcomes.iter().all(|o| o.stats.bias.is_clean()), "{what}");
    }
}

#[test]
fn light_does_not_come_through_what_bends_it_unless_asked_to() {
    let towards = DVec3::new(0.9, 1.0, -0.4).normalize();
    let scene = floor(|builder| {
        let glass = builder.material(absorbing(pane(1.5, false, TINT), 0.3));
        builder.mesh("glass", slab(30.0, 1.0, 1.5), DAffine3::IDENTITY, glass);
        builder.distant_light(towards, Vec3::splat(3.0));
    });
    let outcomes = assert_lit("bent", &scene, Vec3::ZERO, &Settings::default());
    assert!(outcomes.iter().all(|o| o.stats.bias.lights_unreachable == 1));
    let once = 1.0 - fresnel(towards.y, 1.5);
    let through = (once * once * (-0.3 * 0.5 / towards.y).exp() * 3.0 * towards.y) as f32;
    let settings = Settings { transparent_shadows: true, ..Settings::default() };
    assert_lit("straightened", &scene, TINT * TINT * through, &settings);
}

/// Irradiance from all lights, and its standard error.
fn measure(scene: &Scene, tracer: Tracer, settings: &Settings) -> (f64, f64) {
    let one = one_pixel(
        tracer,
        Pattern::Random,
        &[(Effect::Diffuse, [1, 1]), (Effect::Glossy, [1, 1]), (Effect::Light, [1, 1])],
        1,
    );
    let settings = Settings {
        size: (12, 12),
        plans: dapple_integrator::SampleSets {
            pixel: dapple_sampling::SampleSet { nx: 8, ny: 8, pattern: Pattern::Random },
            ..one.plans
        },
        filter: "box:0.001".parse().unwrap(),
        max_bounces: settings.max_bounces,
        transparent_shadows: settings.transparent_shadows,
        ..one
    }
    .with_spp(64);
    common::mean_and_error(&run(scene, &settings))
}

/// A lamp and a sky behind blocks that do not refract, above a floor of `material`.
fn lamp_and_sky(
    material: &TexturedMaterial,
    blocks: &[TexturedMaterial],
    lamp: bool,
    sky: Option<bool>,
) -> Scene {
    let mut builder = common::seen(DVec3::new(0.3, 0.8, 0.2), DVec3::ZERO, 1e-4);
    let floor = builder.material(material.clone());
    builder.mesh("floor", sheet(0.05, 0.0), DAffine3::IDENTITY, floor);
    for (i, block) in blocks.iter().enumerate() {
        let of = builder.material(block.clone());
        let y = 1.0 + 0.3 * i as f32;
        let mesh = if block.base.thin { sheet(50.0, y) } else { slab(50.0, y, y + 0.2) };
        builder.mesh("block", mesh, DAffine3::IDENTITY, of);
    }
    if lamp {
        let bright = builder.material(TexturedMaterial { double_sided: true, ..matte(0.0, 8.0) });
        builder.mesh("lamp", sheet(0.2, 3.0), DAffine3::IDENTITY, bright);
        builder.sphere("bulb", DVec3::new(1.0, 4.0, 0.3), 0.1, bright);
    }
    builder.environment(match sky {
        None => Environment::constant(Vec3::ZERO),
        Some(false) => Environment::constant(Vec3::splat(0.5)),
        Some(true) => bright_spot(),
    });
    builder.build().unwrap()
}

/// A sky that light sampling handles: dim, with a bright patch above.
fn bright_spot() -> Environment {
    let (w, h) = (16, 8);
    let texel = |i: usize| if i / w == 1 { Vec3::splat(9.0) } else { Vec3::splat(0.2) };
    let pixels = (0..w * h).map(texel).collect();
    Environment::picture(Image { width: w, height: h, pixels }, 0.0, 1.0, false).unwrap()
}

#[test]
fn lamps_and_skies_behind_index_matched_blocks_shine_as_without_them() {
    let blocks = [pane(1.0, false, Vec3::ONE), pane(1.0, true, Vec3::ONE)];
    let floors = [("matte", matte(0.8, 0.0)), ("metal", metal(Vec3::ONE, 0.4))];
    for (name, material) in &floors {
        for (lamp, sky) in [(true, None), (false, Some(false)), (false, Some(true)), (true, Some(true))] {
            let open = lamp_and_sky(material, &[], lamp, sky);
            let closed = lamp_and_sky(material, &blocks, lamp, sky);
            for tracer in [Tracer::Path, Tracer::Nested] {
                // With 64 bounces paths find what shadow rays find; with 2 bounces the blocks are too many for paths.
                let many = Settings { max_bounces: 64, ..Settings::default() };
                let transparent = Settings { transparent_shadows: true, ..many.clone() };
                let few = Settings { max_bounces: 2, ..Settings::default() };
                let (a, ea) = measure(&open, tracer, &many);
                let mut closed_by = vec![("64", &many), ("transparent", &transparent)];
                if sky != Some(false) {
                    closed_by.push(("2", &few));
                }
                for (bounces, settings) in closed_by {
                    let (b, eb) = measure(&closed, tracer, settings);
                    let what = format!("{name}, lamp {lamp}, sky {sky:?}, {tracer:?}, {bounces}");
                    let error = (ea * ea + eb * eb).sqrt();
                    if bounces != "2" {
                        assert!(
                            (a - b).abs() <= 4.0 * error + 1e-6,
                            "{what}: {a} without, {b} ± {error} with them"
                        );
                        // The result is also no noisier, because light sampling works through the blocks.
                        assert!(eb < 1.5 * ea + 1e-9, "{what}: error {ea} without, {eb} with them");
                    } else if sky.is_none() {
                        assert!(
                            (a - b).abs() <= 4.0 * error + 1e-6,
                            "{what}: {a} without, {b} ± {error} with them"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn transparent_shadows_count_no_light_twice() {
    // Glass with hardly any refraction: light that shadow rays find straight through, paths find almost straight
    // through.
    let blocks = [pane(1.002, false, Vec3::ONE)];
    for tracer in [Tracer::Path, Tracer::Nested] {
        let open = lamp_and_sky(&matte(0.8, 0.0), &[], true, Some(true));
        let closed = lamp_and_sky(&matte(0.8, 0.0), &blocks, true, Some(true));
        let many = Settings { max_bounces: 64, ..Settings::default() };
        let (a, ea) = measure(&open, tracer, &many);
        let (b, eb) = measure(&closed, tracer, &Settings { transparent_shadows: true, ..many });
        assert!(
            (a - b).abs() < 4.0 * (ea * ea + eb * eb).sqrt() + 2e-3 * a,
            "{tracer:?}: {a} without, {b} with it"
        );
    }
}

/// A roughness below the threshold at which the BSDF is rough: the pane is smooth, and shadow rays must treat it as
/// such.
#[test]
fn a_pane_of_imperceptible_roughness_is_as_clear_as_a_smooth_one() {
    let scene = floor(|builder| {
        let smooth = pane(1.0, true, Vec3::ONE);
        let base = Material { roughness: 0.03, ..smooth.base };
        let glass = builder.material(TexturedMaterial { base, ..smooth });
        builder.mesh("pane", sheet(3.0, 1.0), DAffine3::IDENTITY, glass);
        builder.distant_light(DVec3::Y, Vec3::ONE);
    });
    assert_lit("nearly smooth pane", &scene, Vec3::ONE, &Settings::default());
}

#[test]
fn what_is_lost_among_too_many_panes_is_told() {
    for (panes, passes) in [(256, true), (257, false)] {
        let scene = floor(|builder| {
            let glass = builder.material(pane(1.0, true, Vec3::ONE));
            for i in 0..panes {
                builder.mesh("pane", sheet(3.0, 1.0 + 0.01 * i as f32), DAffine3::IDENTITY, glass);
            }
            builder.distant_light(DVec3::Y, Vec3::ONE);
        });
        let exact = if passes { Vec3::ONE } else { Vec3::ZERO };
        for outcome in assert_lit("many panes", &scene, exact, &Settings::default()) {
            let panes = outcome.stats.bias.panes;
            assert_eq!(panes.count > 0, !passes);
            assert_eq!(panes.energy > 0.0, !passes);
        }
    }
}

#[test]
fn only_lights_and_surfaces_that_can_are_said_to_lose_light() {
    let count = |material: TexturedMaterial, suns: u32, transparent: bool| {
        let scene = floor(|builder| {
            let of = builder.material(material.clone());
            builder.mesh("slab", slab(0.2, 2.0, 2.2), DAffine3::IDENTITY, of);
            (0..suns).for_each(|_| builder.distant_light(DVec3::Y, Vec3::ONE));
            builder.point_light(DVec3::Y * 5.0, Vec3::ZERO, f64::INFINITY);
        });
        let settings =
            Settings { transparent_shadows: transparent, size: (1, 1), ..Settings::default() }.with_spp(1);
        run(&scene, &settings).stats.bias.lights_unreachable
    };
    assert_eq!(count(pane(1.5, false, Vec3::ONE), 3, false), 3);
    assert_eq!(count(pane(1.5, false, Vec3::ONE), 3, true), 3, "its reflection");
    assert_eq!(count(pane(1.0, false, Vec3::ONE), 3, false), 0);
    assert_eq!(count(metal(Vec3::ONE, 0.0), 2, false), 2);
    assert_eq!(count(metal(Vec3::ONE, 0.3), 2, false), 0);
    assert_eq!(count(matte(0.5, 0.0), 2, false), 0);
    assert_eq!(count(metal(Vec3::ONE, 0.0), 0, false), 0);
}

#[test]
fn all_kernels_see_the_same_through_panes_and_bodies() {
    let build = || {
        let mut scene = floor(|builder| {
            let glass = builder.material(pane(1.4, true, TINT));
            let dark = builder.material(absorbing(pane(1.0, false, Vec3::ONE), 0.3));
            let clear = builder.material(pane(1.0, false, Vec3::splat(0.9)));
            for i in 0..8 {
                let y = 1.0 + 0.2 * i as f32;
                builder.mesh("pane", sheet(3.0, y), DAffine3::from_rotation_x(0.03 * f64::from(i)), glass);
                builder.mesh(
                    "body",
                    slab(2.0, y + 0.05, y + 0.17),
                    DAffine3::from_rotation_z(0.02 * f64::from(i)),
                    dark,
                );
                builder.mesh("inner", slab(1.5, y + 0.1, y + 0.3), DAffine3::IDENTITY, clear);
            }
            builder.point_light(DVec3::new(0.3, 5.0, 0.1), Vec3::splat(9.0), f64::INFINITY);
            let bright = builder.material(TexturedMaterial { double_sided: true, ..matte(0.0, 8.0) });
            builder.mesh("lamp", sheet(0.2, 4.0), DAffine3::IDENTITY, bright);
        });
        scene.cameras[0].camera.projection = dapple_camera::Projection::Perspective { tan_half: 0.02 };
        scene
    };
    for tracer in [Tracer::Path, Tracer::Nested] {
        let settings = Settings {
            size: (6, 6),
            max_bounces: if tracer == Tracer::Path { 40 } else { 6 },
            ..one_pixel(tracer, Pattern::Sobol, &[(Effect::Diffuse, [2, 2]), (Effect::Light, [2, 2])], 8)
        };
        let pictures: Vec<Vec<Vec3>> = Kernel::available()
            .into_iter()
            .map(|kernel| {
                let mut scene = build();
                scene.accel = scene.accel.with_kernel(kernel);
                run(&scene, &settings).film.mean().pixels.clone()
            })
            .collect();
        assert!(pictures[0].iter().any(|p| p.x > 0.0));
        assert!(pictures.iter().all(|p| *p == pictures[0]), "{tracer:?}");
    }
}
