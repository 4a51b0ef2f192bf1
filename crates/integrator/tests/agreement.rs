//! Different computations of the same image agree: strategies by z-test; threads, crops, passes and kernels bit for
//! bit.

mod common;

use common::*;
use dapple_geometry::bvh::Kernel;
use dapple_integrator::math::PixelRect;
use dapple_integrator::settings::Strategy;
use dapple_integrator::{Outcome, Settings};
use dapple_sampling::{Moments, Pattern};
use dapple_scene::{Scene, SceneBuilder};
use dapple_testkit::z_test;
use glam::{DAffine3, DVec3, Vec3};

/// A scene like that of [Veach 1997, fig. 9.2]: plates of increasing roughness under spheres of decreasing size.
fn plates() -> Scene {
    let mut builder: SceneBuilder = seen(DVec3::new(0.0, 2.0, 9.0), DVec3::new(0.0, 0.6, 0.0), 0.7);
    for (i, roughness) in [0.1, 0.25, 0.5].into_iter().enumerate() {
        let plate = builder.material(metal(Vec3::splat(0.8), roughness));
        let (z, tilt) = (2.0 - 1.6 * i as f32, 0.25 + 0.25 * i as f32);
        let along = Vec3::new(0.0, tilt, -1.0);
        builder.mesh(
            "plate",
            quad(Vec3::new(-3.0, 0.3 * i as f32, z), Vec3::X * 6.0, along),
            DAffine3::IDENTITY,
            plate,
        );
    }
    for (x, radius, power) in [(-2.4, 0.6, 1.0), (-0.6, 0.25, 6.0), (1.0, 0.08, 50.0), (2.4, 0.02, 800.0)] {
        let light = builder.material(matte(0.0, power));
        builder.sphere("light", DVec3::new(x, 2.8, -3.0), radius, light);
    }
    builder.build().unwrap()
}

fn by_strategy(scene: &Scene, strategy: Strategy, seed: u64) -> Outcome {
    let settings = Settings {
        size: (48, 32),
        seed,
        strategy,
        max_bounces: 2,
        pattern: Pattern::Random,
        ..Settings::default()
    }
    .with_spp(1024);
    run(scene, &settings)
}

/// The four plates and five lights of the scene file in scenes/.
#[cfg(feature = "gltf")]
fn veach_mis() -> Scene {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/veach_mis.gltf");
    let options = dapple_scene::gltf::Options::default();
    dapple_scene::gltf::read(file.as_ref(), &options).unwrap().build().unwrap()
}

#[test]
fn light_and_bsdf_sampling_agree_with_both() {
    strategies_agree(&plates());
    #[cfg(feature = "gltf")]
    strategies_agree(&veach_mis());
}

fn strategies_agree(scene: &Scene) {
    let both = by_strategy(scene, Strategy::Both, 1);
    for (other, seed) in [(Strategy::LightOnly, 2), (Strategy::BsdfOnly, 3)] {
        let other = by_strategy(scene, other, seed);
        let (a, b) = (both.film.mean(), other.film.mean());
        let (va, vb) = (both.film.variance(), other.film.variance());
        let sum = |f: &dyn Fn(usize) -> f64| (0..a.pixels.len()).map(f).sum::<f64>();
        let difference = sum(&|i| f64::from(a.pixels[i].y - b.pixels[i].y));
        let variance = sum(&|i| f64::from(va.pixels[i].y + vb.pixels[i].y));
        let z = z_test::welch(difference, variance.sqrt(), 0.0, 0.0);
        println!(
            "{}: z = {:.2}, standard error {:.2e}",
            scene.name,
            z.z,
            variance.sqrt() / sum(&|i| f64::from(a.pixels[i].y))
        );
        assert!(z.p > 1e-4, "{}: z = {}", scene.name, z.z);
    }
}

#[test]
fn mis_has_the_least_variance() {
    let scenes = [
        plates(),
        #[cfg(feature = "gltf")]
        veach_mis(),
    ];
    for scene in scenes {
        let variance = |strategy| {
            let outcome = by_strategy(&scene, strategy, 5);
            outcome.film.variance().pixels.iter().map(|p| f64::from(p.y)).sum::<f64>()
        };
        let both = variance(Strategy::Both);
        assert!(
            both < variance(Strategy::LightOnly) && both < variance(Strategy::BsdfOnly),
            "{}",
            scene.name
        );
    }
}

fn bits(outcome: &Outcome) -> Vec<[u32; 3]> {
    outcome.film.mean().pixels.iter().map(|p| p.to_array().map(f32::to_bits)).collect()
}

#[test]
fn threads_change_no_bit() {
    let scene = plates();
    let settings =
        |threads| Settings { size: (70, 37), ..Settings::default() }.with_threads(threads).with_spp(5);
    let one = bits(&run(&scene, &settings(1)));
    assert_eq!(one, bits(&run(&scene, &settings(2))));
    assert_eq!(one, bits(&run(&scene, &settings(7))));
}

#[test]
fn a_crop_has_the_full_pictures_pixels() {
    let scene = plates();
    for pattern in [Pattern::Sobol, Pattern::Stratified] {
        let settings = Settings { size: (64, 48), pattern, ..Settings::default() }.with_spp(4);
        let full = run(&scene, &settings).film.mean();
        let crop = PixelRect { x0: 11, y0: 7, x1: 43, y1: 30 };
        let part = run(&scene, &Settings { crop: Some(crop), ..settings }).film.mean();
        for (i, p) in part.pixels.iter().enumerate() {
            let (x, y) = (11 + i % part.width, 7 + i / part.width);
            assert_eq!(*p, full.at(x, y));
        }
    }
}

#[test]
fn watching_the_first_hit_changes_no_bit() {
    let scene = plates();
    let settings = Settings { size: (40, 30), ..Settings::default() }.with_spp(3);
    let aovs = dapple_integrator::Aov::ALL.map(|(aov, _)| aov).to_vec();
    let watched = run(&scene, &Settings { aovs, ..settings.clone() });
    assert_eq!(bits(&run(&scene, &settings)), bits(&watched));
    // The image is one of the layers, and a Cryptomatte has six.
    assert_eq!(watched.layers.layers.len(), dapple_integrator::Aov::ALL.len() + 5);
}

#[test]
fn every_traversal_kernel_gives_the_same_picture() {
    let mut scene = plates();
    let settings = Settings { size: (40, 30), ..Settings::default() }.with_spp(3);
    let expected = bits(&run(&scene, &settings));
    for kernel in Kernel::available() {
        scene.accel = scene.accel.with_kernel(kernel);
        assert_eq!(bits(&run(&scene, &settings)), expected, "{}", kernel.name());
    }
}

#[test]
fn replay_returns_the_sample_of_the_render() {
    let scene = plates();
    let settings = Settings { size: (20, 16), ..Settings::default() }.with_spp(1);
    let picture = run(&scene, &settings).film.mean();
    for (x, y) in [(3, 4), (10, 12), (19, 15)] {
        let (_, radiance) = dapple_integrator::replay(&scene, &scene.cameras[0].camera, &settings, (x, y), 0);
        assert_eq!(radiance, picture.at(x as usize, y as usize));
    }
}

/// Every pattern is an unbiased estimate of the same mean.
#[test]
fn patterns_agree() {
    let scene = plates();
    let estimate = |pattern| {
        let means: Moments = (0..12)
            .map(|seed| {
                mean_and_error(&run(
                    &scene,
                    &Settings { size: (24, 16), pattern, seed, ..Settings::default() }.with_spp(36),
                ))
                .0
            })
            .collect();
        (means.mean, means.standard_error())
    };
    let random = estimate(Pattern::Random);
    for pattern in [Pattern::Stratified, Pattern::Sobol] {
        let other = estimate(pattern);
        let z = z_test::welch(random.0, random.1, other.0, other.1);
        assert!(z.p > 1e-4, "{pattern}: {other:?} against {random:?}");
    }
}
