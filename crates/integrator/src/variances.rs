//! Analysis of variance: the share of each integral in the variance of a pixel.
//!
//! A sample of the distribution tracer with one random point for each integral is f(pixel, lens, time, light, lobes).
//! By the law of total variance Var f = Var E[f | pixel] + E Var[f | pixel], and the last term is split again by the
//! lens, and so on inwards; at the first hit, lights and lobes are summed, so that their variances add up. Each term is
//! half the mean squared difference of two samples that share some points and not others [Sobol' 2001; Jansen 1999]: no
//! term is the difference of two means of many samples, and none needs more than one point at a time.

use crate::effects::{Effect, SampleSets};
use crate::first_hit_sums::FirstHit;
use crate::job::Job;
use crate::kernel;
use crate::settings::{MethodKind, Settings};
use dapple_camera::Camera;
use dapple_math::PixelRect;
use dapple_sampling::{Pattern, SampleSet};
use dapple_scene::Scene;
use glam::DVec3;

/// Integrals around the camera ray, from the outermost in.
const OUTER: [Effect; 3] = [Effect::Pixel, Effect::Lens, Effect::Time];

/// Integrals that are summed at the first hit.
const INNER: [Effect; 4] = [Effect::Light, Effect::Glossy, Effect::Refract, Effect::Diffuse];

/// Variances of one sample, summed over three channels, and ray counts, as means over pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Variances {
    /// Variance of each integral, in the order of [`Effect::ALL`].
    pub parts: [f64; 7],
    /// Variance of random alpha tests, which are not an integral of their own.
    pub rest: f64,
    /// Mean radiance over three channels.
    pub mean: f64,
    /// Rays of one sample.
    pub rays: f64,
    /// Additional rays for one more point of each integral; for the outer integrals, all rays of a sample.
    pub more_rays: [f64; 7],
}

impl Variances {
    /// The total variance.
    pub fn total(&self) -> f64 {
        self.parts.iter().sum::<f64>() + self.rest
    }
}

/// Variances and cost of samples with one point for each integral, from `samples` pairs of samples in every pixel of
/// `rect`.
pub fn variances(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    rect: PixelRect,
    samples: u32,
) -> Variances {
    let settings = one_each(settings);
    let base = Job::new(scene, camera, &settings);
    let again: Vec<Job<'_>> = Effect::ALL
        .iter()
        .map(|(e, _)| Job { again: Some(*e), ..Job::new(scene, camera, &settings) })
        .collect();
    let doubled: Vec<Settings> = INNER.iter().map(|e| two_of(&settings, *e)).collect();
    let doubled: Vec<Job<'_>> = doubled.iter().map(|s| Job::new(scene, camera, s)).collect();
    let mut sums = Sums::default();
    for y in rect.y0..rect.y1 {
        for x in rect.x0..rect.x1 {
            for s in 0..samples {
                sums.add(&base, &again, &doubled, (x, y), 2 * s);
            }
        }
    }
    let has = crate::forecast::present_in(scene, camera, &settings);
    sums.finish(scene.has_alpha(), |effect| has.contains(&effect) && !settings.plans.is_off(effect))
}

/// One random point for every integral that is on.
fn one_each(settings: &Settings) -> Settings {
    let plans = settings.plans.map(|_, _| SampleSet::new(1, Pattern::Random));
    Settings { plans, ..settings.clone() }
        .with_method(MethodKind::Distribution)
        .with_distribution(|d| d.combine = Default::default())
        .with_distribution(|d| d.secondary = 1)
}

fn two_of(settings: &Settings, effect: Effect) -> Settings {
    let two = |e, plan| if e == effect { SampleSet::new(2, Pattern::Random) } else { plan };
    let plans: SampleSets = settings.plans.map(two);
    Settings { plans, ..settings.clone() }
}

/// Sums over the samples.
#[derive(Default)]
struct Sums {
    n: f64,
    mean: f64,
    /// Half squared differences: of independent samples; of samples that share everything outside of each integral
    /// (outer), or all but one integral (inner).
    independent: f64,
    again: [f64; 7],
    rays: f64,
    doubled: [f64; 4],
}

impl Sums {
    fn add(&mut self, base: &Job<'_>, again: &[Job<'_>], doubled: &[Job<'_>], pixel: (u32, u32), index: u32) {
        let (value, rays) = sample(base, pixel, index);
        let (other, _) = sample(base, pixel, index + 1);
        self.n += 1.0;
        self.mean += (value + other).element_sum() / 6.0;
        self.independent += 0.5 * (value - other).length_squared();
        self.rays += rays as f64;
        for (sum, job) in self.again.iter_mut().zip(again) {
            *sum += 0.5 * (value - sample(job, pixel, index).0).length_squared();
        }
        for (sum, job) in self.doubled.iter_mut().zip(doubled) {
            *sum += sample(job, pixel, index).1 as f64;
        }
    }

    /// Integrals that the scene does not have get no variance.
    fn finish(self, holes: bool, has: impl Fn(Effect) -> bool) -> Variances {
        let n = self.n.max(1.0);
        let rays = self.rays / n;
        let (mut parts, mut more_rays) = ([0.0; 7], [rays; 7]);
        let mut around = self.independent;
        for (i, (effect, _)) in Effect::ALL.iter().enumerate() {
            if !has(*effect) {
                more_rays[i] = 0.0;
            } else if OUTER.contains(effect) {
                parts[i] = (around - self.again[i]).max(0.0) / n;
                around = self.again[i];
            } else {
                parts[i] = self.again[i] / n;
                more_rays[i] = (self.doubled[i - OUTER.len()] / n - rays).max(0.0);
            }
        }
        let rest = around / n - parts[OUTER.len()..].iter().sum::<f64>();
        let rest = if holes { rest.max(0.0) } else { 0.0 };
        Variances { parts, rest, mean: self.mean / n, rays, more_rays }
    }
}

fn sample(job: &Job<'_>, pixel: (u32, u32), index: u32) -> (DVec3, u64) {
    let (mut first, mut rays) = (FirstHit::of(job.settings), 0);
    let (value, weight) = kernel::choose(job).0.sample(job, pixel, index, &mut first, &mut rays);
    let value = value.as_dvec3() * f64::from(weight);
    (if value.is_finite() { value } else { DVec3::ZERO }, rays)
}
