//! All estimators of the same integrals: nested, paired, and as paths; each with every pattern.

use dapple_integrator::camera::Camera;
use dapple_integrator::settings::Strategy;
use dapple_integrator::{Combine, Effect, MethodKind, SampleSets, Settings, render};
use dapple_sampling::{Moments, Pattern, SampleSet};
use dapple_scene::Scene;
use std::ops::ControlFlow;

/// The estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tracer {
    Nested,
    Paired,
    Path,
}

pub const TRACERS: [Tracer; 3] = [Tracer::Nested, Tracer::Paired, Tracer::Path];
pub const PATTERNS: [Pattern; 4] = [Pattern::Grid, Pattern::Random, Pattern::Stratified, Pattern::Sobol];
/// The patterns with unbiased estimates.
pub const UNBIASED: [Pattern; 3] = [Pattern::Random, Pattern::Stratified, Pattern::Sobol];

/// One pixel in which only `integrals` are on: with their sample counts if nested; with `samples` joint samples if
/// paired or as paths. In paired mode, the pixel is always one of the integrals.
pub fn one_pixel(
    tracer: Tracer,
    pattern: Pattern,
    integrals: &[(Effect, [u32; 2])],
    samples: u32,
) -> Settings {
    let mut plans = SampleSets::default();
    for (effect, _) in Effect::ALL {
        *plans.of_mut(effect) = SampleSet::OFF;
    }
    for &(effect, [nx, ny]) in integrals {
        *plans.of_mut(effect) = match tracer {
            Tracer::Nested => SampleSet { nx, ny, pattern },
            Tracer::Paired | Tracer::Path => SampleSet::new(samples, pattern),
        };
    }
    if tracer == Tracer::Paired {
        plans.pixel = SampleSet::new(samples, pattern);
    }
    Settings { size: (1, 1), pattern, max_bounces: 1, plans, ..Settings::default() }
        .with_method(if tracer == Tracer::Path { MethodKind::Path } else { MethodKind::Distribution })
        .with_threads(1)
        .with_spp(samples)
        .with_path(|p| p.roulette = false)
        .with_distribution(|d| {
            d.combine = if tracer == Tracer::Paired { Combine::Paired } else { Combine::Nested }
        })
}

/// Lights are found by BSDF sampling alone.
pub fn by_chance(settings: Settings) -> Settings {
    let light = SampleSet::new(1, settings.pattern);
    Settings { strategy: Strategy::BsdfOnly, plans: SampleSets { light, ..settings.plans }, ..settings }
}

/// The image values for one seed, row by row; they must be grey.
pub fn values(scene: &Scene, camera: &Camera, settings: &Settings, seed: u64) -> Vec<f64> {
    let settings = Settings { seed, ..settings.clone() };
    let outcome = render(scene, camera, &settings, &|_| ControlFlow::Continue(()));
    assert_eq!(outcome.stats.bad_sample_count, 0);
    let mean = outcome.film.mean();
    assert!(mean.pixels.iter().all(|p| p.x == p.y && p.x == p.z));
    mean.pixels.iter().map(|p| f64::from(p.x)).collect()
}

/// Moments of each pixel over the seeds 0 … n − 1. A `grid` that is not permuted needs only one seed.
pub fn replicas(scene: &Scene, camera: &Camera, settings: &Settings, n: u64) -> Vec<Moments> {
    let pixels = (settings.size.0 * settings.size.1) as usize;
    let mut moments = vec![Moments::default(); pixels];
    for seed in 0..n {
        let values = values(scene, camera, settings, seed);
        moments.iter_mut().zip(values).for_each(|(m, v)| m.add(v));
    }
    moments
}

/// Asserts a mean within 4 standard errors, with `floor` for the rounding of f32.
#[track_caller]
pub fn assert_mean(what: &str, moments: &Moments, exact: f64, floor: f64) {
    let (mean, error) = (moments.mean, moments.standard_error());
    assert!((mean - exact).abs() <= 4.0 * error + floor, "{what}: {mean} ± {error}, exact {exact}");
}

/// As [`assert_mean`], with a standard error of at most `most`; a larger one would make the test inconclusive.
#[track_caller]
pub fn assert_mean_known_to(what: &str, moments: &Moments, exact: f64, most: f64) {
    assert!(
        moments.standard_error() <= most,
        "{what}: {} is too large to be conclusive",
        moments.standard_error()
    );
    assert_mean(what, moments, exact, 2e-5 * exact.abs() + 1e-9);
}
