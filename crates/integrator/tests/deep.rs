//! Ray trees thousands of bounces deep are correct, and need only a small stack.

mod common;

use common::*;
use dapple_integrator::{MethodKind, Outcome, SampleSets, Settings, forecast, render};
use dapple_lights::Environment;
use dapple_materials::{Material, Mirror};
use dapple_sampling::{Pattern, SampleSet};
use dapple_scene::{Scene, TexturedMaterial};
use glam::{DAffine3, DVec3, Vec3};
use std::ops::ControlFlow;
use std::thread;
use std::time::{Duration, Instant};

/// The inside of a cube of mirrors with reflectance `kr` and the given `emission`.
fn hall_of_mirrors(kr: f32, emission: f32) -> Scene {
    let mut builder = seen(DVec3::new(0.1, -0.2, 0.3), DVec3::new(0.7, 0.9, -0.4), 0.6);
    builder.no_default_light();
    let mirror = builder.material(TexturedMaterial {
        base: Material { mirror: Some(Mirror { kr: Vec3::splat(kr), blur: 0.0 }), ..Material::default() },
        emission: Vec3::splat(emission),
        double_sided: true,
        ..TexturedMaterial::default()
    });
    builder.mesh("hall", inward_cube(), DAffine3::IDENTITY, mirror);
    builder.build().unwrap()
}

fn settings(method: MethodKind, threads: usize, max_bounces: u32) -> Settings {
    let plans = SampleSets { pixel: SampleSet::new(1, Pattern::Stratified), ..SampleSets::default() };
    let (spp, roulette) = (Some(1), false);
    Settings { size: (2, 2), max_bounces, plans, ..Settings::default() }
        .with_method(method)
        .with_threads(threads)
        .with_spp(spp)
        .with_path(|p| p.roulette = roulette)
}

/// Runs on a thread whose stack has one megabyte.
fn on_a_small_stack<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    thread::scope(|scope| {
        let small = thread::Builder::new().stack_size(1 << 20);
        small.spawn_scoped(scope, work).unwrap().join().unwrap()
    })
}

fn values(outcome: &Outcome) -> Vec<f64> {
    outcome.film.mean().pixels.iter().map(|p| f64::from(p.x)).collect()
}

/// Σ ε·krᵏ over the bounces 0 … n.
#[test]
fn ten_thousand_bounces_between_mirrors() {
    let (kr, emission) = (0.9998f32, 2e-4f32);
    let scene = hall_of_mirrors(kr, emission);
    for bounces in [63, 64, 65, 66, 130, 10_000] {
        let exact = f64::from(emission) * (1.0 - f64::from(kr).powi(bounces + 1)) / (1.0 - f64::from(kr));
        for method in [MethodKind::Path, MethodKind::Distribution] {
            for threads in [1, 2] {
                let settings = settings(method, threads, bounces as u32);
                let outcome = on_a_small_stack(|| run(&scene, &settings));
                for value in values(&outcome) {
                    let off = (value / exact - 1.0).abs();
                    assert!(
                        off < 2e-4,
                        "{method:?}, {bounces} bounces, {threads} threads: {value}, exact {exact}"
                    );
                }
                assert_eq!(outcome.stats.rays, 4 * (bounces as u64 + 1));
            }
        }
    }
}

/// Between two clear panes of a large index each bounce transmits some light and keeps the rest: every vertex has two
/// rays, of which the heavier one continues. Under a constant sky all of them together find its radiance.
#[test]
fn branches_of_a_deep_tree_are_all_there() {
    let mut builder = seen(DVec3::ZERO, DVec3::new(0.02, 1.0, 0.01), 1e-3);
    let pane = builder.material(TexturedMaterial {
        base: Material {
            metallic: 0.0,
            roughness: 0.0,
            transmission: 1.0,
            ior: 40.0,
            thin: true,
            ..Material::default()
        },
        double_sided: true,
        ..TexturedMaterial::default()
    });
    for y in [-1.0, 1.0] {
        let wide = quad(Vec3::new(-300.0, y, 300.0), Vec3::X * 600.0, Vec3::Z * -600.0);
        builder.mesh("pane", wide, DAffine3::IDENTITY, pane);
    }
    builder.environment(Environment::constant(Vec3::ONE));
    let scene = builder.build().unwrap();
    let few = run(&scene, &settings(MethodKind::Distribution, 1, 40));
    assert!(
        values(&few).iter().all(|v| *v < 0.99),
        "the panes transmit too much light for a meaningful test"
    );
    let all = on_a_small_stack(|| run(&scene, &settings(MethodKind::Distribution, 1, 3000)));
    assert!(values(&all).iter().all(|v| (v - 1.0).abs() < 1e-4), "{:?}", values(&all));
    assert!(all.stats.rays > 4 * 2 * 200, "{} rays", all.stats.rays);
}

/// No light escapes or is absorbed, and every vertex sends on two rays of half the light each: the tree is as deep and
/// as wide as light can be halved. It does not terminate in practice, but takes no more stack for any number of
/// bounces.
#[test]
fn a_tree_without_end_takes_a_small_stack() {
    let mut builder = seen(DVec3::new(0.1, -0.2, 0.3), DVec3::new(0.7, 0.9, -0.4), 0.6);
    builder.no_default_light();
    let halves = TexturedMaterial {
        base: Material { metallic: 0.5, roughness: 0.4, ..Material::default() },
        emission: Vec3::splat(1e-3),
        double_sided: true,
        ..TexturedMaterial::default()
    };
    let wall = builder.material(halves);
    builder.mesh("room", inward_cube(), DAffine3::IDENTITY, wall);
    let scene = builder.build().unwrap();
    for threads in [1, 2] {
        let mut settings = settings(MethodKind::Distribution, threads, u32::MAX);
        settings = settings.with_time_limit(Duration::from_millis(300));
        let outcome = on_a_small_stack(|| run(&scene, &settings));
        assert_eq!((outcome.stats.spp, outcome.stats.timed_out), (0, true));
        assert!(outcome.stats.rays > 1000);
    }
}

/// Perfect mirrors with the maximum number of bounces: neither tracer ends by itself, and neither accumulates memory.
#[test]
fn endless_chains_end_when_told() {
    let scene = hall_of_mirrors(1.0, 1e-6);
    for method in [MethodKind::Path, MethodKind::Distribution] {
        for threads in [1, 2] {
            let settings = settings(method, threads, u32::MAX);
            let start = Instant::now();
            let outcome = render(&scene, &scene.cameras[0].camera, &settings, &|progress| {
                if progress.elapsed > Duration::from_millis(100) {
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            });
            assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
            assert_eq!((outcome.stats.spp, outcome.stats.stopped), (0, true));
        }
    }
}

/// Forecasts list a thousand depths and sum the others: in a hall of mirrors there is one ray per bounce.
#[test]
fn forecasts_of_deep_trees_are_short() {
    let scene = hall_of_mirrors(1.0, 0.0);
    for bounces in [999, 1000, 1001, 1002, 5000, u32::MAX] {
        for method in [MethodKind::Path, MethodKind::Distribution] {
            let settings = settings(method, 1, bounces);
            let found = forecast(&scene, &scene.cameras[0].camera, &settings);
            assert_eq!(found.total(), f64::from(bounces) + 1.0, "{method:?}, {bounces} bounces");
            assert!(found.rows.len() <= 1001, "{} rows", found.rows.len());
        }
    }
}
