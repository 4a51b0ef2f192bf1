//! What will a picture of a given error cost, and which integral is to blame?
//!
//! A pilot of a few samples over the picture says where the errors are and how bright it is. In blocks that stand for
//! the picture ([`crate::estimate`]), [`dapple_integrator::variances()`] splits the variance by effect. From that follow
//! the counts of the distribution tracer that reach a given error with the fewest rays, and from pairs of independent
//! renders of the blocks the error of a given count, for the distribution tracer with random points and for the path
//! tracer as it is set. Independent points have a squared error ∝ 1/n; the path tracer's other points are rendered at two
//! counts, and the line through both in logarithms is followed to the wanted error. *Approximation*: that the rate
//! stays; the interval grows with the distance.
//!
//! All this is done in independent groups of blocks, from whose differences the intervals follow. As long as an interval is
//! wide the pilot goes on, with twice as many groups, or with larger counts, nearer to the wanted ones; how far is a number
//! of rays, so that the same call says the same on every machine, or a time, if one is given. An interval that is not known
//! even then is not told.

mod pilot;
mod wanted;

use crate::statistics;
use dapple_integrator::camera::Camera;
use dapple_integrator::forecast::present_in;
use dapple_integrator::sampling::{Pattern, Plan};
use dapple_integrator::scene::Scene;
use dapple_integrator::{Combine, Effect, MethodKind, Plans, Settings, Variances};
use pilot::Pilot;
use std::time::{Duration, Instant};
pub use wanted::NARROW;
use wanted::Wanted;

/// What carries which part of the variance, and what that costs.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Budget {
    /// The wanted relative RMSE.
    pub error_limit: f64,
    /// Mean radiance.
    pub mean: f64,
    /// Effects that the scene has, in the order in which they are nested; shares add up to 1.
    pub effects: Vec<Share>,
    /// By method.
    pub predictions: Vec<Prediction>,
}

/// An effect's part of the variance of one sample.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Share {
    /// Its name, or `holes`: which surface a ray meets where some are cut out.
    pub effect: String,
    /// 0 to 1.
    pub share: f64,
    /// Ends of its confidence interval.
    pub share_ci: [f64; 2],
}

/// What reaches the wanted error.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Prediction {
    /// `path` or `distribution`.
    pub method: String,
    /// Options of `dapple render`.
    pub options: String,
    /// Samples per pixel, or points over the pixel's area.
    pub samples: f64,
    /// Ends of their confidence interval; `None` where they are more than a factor [`statistics::WIDEST`] apart.
    pub samples_ci: Option<[f64; 2]>,
    /// Rays of the whole picture.
    pub rays: f64,
    /// Seconds of rendering, at the speed of the pilot.
    pub seconds: f64,
    /// With the interval of the samples, and half as much again for the pilot's short time.
    pub seconds_ci: Option<[f64; 2]>,
    /// Whether the ends are within a factor of [`NARROW`]; if not, a longer pilot is needed.
    pub is_narrow: bool,
}

/// The most points by which one integral is split.
const MOST: f64 = 64.0;

/// The budget for a picture of `settings` with relative RMSE `limit`. With `time`, a pilot whose intervals are wide goes on
/// while its next step should end within that time; its first steps are taken in any case.
pub fn budget(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    limit: f64,
    confidence: f64,
    time: Option<Duration>,
) -> Budget {
    let start = Instant::now();
    let pilot = Pilot::new(scene, camera, settings);
    let present = present_in(scene, camera, settings);
    let wanted = Wanted { limit, confidence, start, time };
    let variances = wanted.variances(&pilot, &present);
    let shares = shares(&variances, &present, confidence);
    let tree = settings.clone().with_method(MethodKind::Distribution);
    let tree = Settings { plans: plans(&tree.plans, &sum(&variances)), ..tree }
        .with_distribution(|d| d.combine = Combine::Nested)
        .with_distribution(|d| d.secondary = 1);
    let predictions = vec![wanted.path(&pilot, settings), wanted.tree(&pilot, &tree, &present)];
    Budget { error_limit: limit, mean: pilot.mean, effects: shares, predictions }
}

/// All together.
fn sum(all: &[Variances]) -> Variances {
    let mut sum = Variances { parts: [0.0; 7], rest: 0.0, mean: 0.0, rays: 0.0, more_rays: [0.0; 7] };
    for one in all {
        sum.parts.iter_mut().zip(one.parts).for_each(|(a, b)| *a += b);
        sum.more_rays.iter_mut().zip(one.more_rays).for_each(|(a, b)| *a += b);
        sum.rest += one.rest;
        sum.rays += one.rays;
    }
    sum
}

fn shares(all: &[Variances], present: &[Effect], confidence: f64) -> Vec<Share> {
    let z = reach(all.len(), confidence);
    let share = |name: &str, part: &dyn Fn(&Variances) -> f64| {
        let ratio = |all: &[Variances]| {
            let (part, total): (f64, f64) =
                (all.iter().map(part).sum(), all.iter().map(Variances::total).sum());
            if total > 0.0 { part / total } else { 0.0 }
        };
        let (share, error) = (ratio(all), jackknife(all, &ratio));
        let share_ci = [(share - z * error).max(0.0), (share + z * error).min(1.0)];
        Share { effect: name.into(), share, share_ci }
    };
    let mut shares: Vec<Share> = Effect::ALL
        .iter()
        .enumerate()
        .filter(|(_, (effect, _))| present.contains(effect))
        .map(|(i, (_, name))| share(name, &|v: &Variances| v.parts[i]))
        .collect();
    let rest = share("holes", &|v: &Variances| v.rest);
    shares.extend((rest.share > 0.0).then_some(rest));
    shares
}

/// Standard errors from a value to the ends of its interval, where the standard error comes from so many groups.
fn reach(groups: usize, confidence: f64) -> f64 {
    statistics::student(0.5 + 0.5 * confidence, groups.saturating_sub(1).max(1) as f64)
}

/// The standard error of a statistic of independent parts, by leaving out one after the other [Efron 1982].
fn jackknife<T: Clone>(all: &[T], statistic: &dyn Fn(&[T]) -> f64) -> f64 {
    let n = all.len() as f64;
    let without = |i: usize| {
        let mut rest = all.to_vec();
        rest.remove(i);
        statistic(&rest)
    };
    let values: Vec<f64> = (0..all.len()).map(without).filter(|v| v.is_finite()).collect();
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    if values.len() < 2 { f64::INFINITY } else { ((n - 1.0) / n * squares).sqrt() }
}

/// Points of every integral for the fewest rays. With A the variance around the first hit, V that of an integral there
/// and c the rays of one of its points, (A + Σ V/n)(1 + Σ n·c) is least at n = √(V / (c·A)): one camera ray costs 1. A
/// further point of lens or time costs as much as one of the pixel, and gains less.
fn plans(set: &Plans, v: &Variances) -> Plans {
    let mut plans = *set;
    let rays = v.rays.max(f64::MIN_POSITIVE);
    let around: f64 = v.parts[..3].iter().sum();
    let camera = rays - v.more_rays[3..].iter().sum::<f64>();
    for (i, (effect, _)) in Effect::ALL.iter().enumerate().filter(|(_, (e, _))| !set.is_off(*e)) {
        let (part, cost) = (v.parts[i], v.more_rays[i] / camera.max(1e-3 * rays));
        let n = if i < 3 || part <= 0.0 { 1.0 } else { (part / (cost * around)).sqrt() };
        let n = if n.is_nan() { 1.0 } else { n.round().clamp(1.0, MOST) };
        *plans.of_mut(*effect) = Plan::new(n as u32, Pattern::Random);
    }
    plans
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The standard error of a mean is s/√n.
    #[test]
    fn leaving_one_out() {
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let found = jackknife(&[1.0, 2.0, 3.0, 6.0], &mean);
        assert!((found - (14.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12, "{found}");
    }

    /// Where the light makes four times the variance of all around it and a point costs one ray, two points are best.
    #[test]
    fn counts_follow_variance_and_cost() {
        let mut v = Variances { parts: [0.0; 7], rest: 0.0, mean: 1.0, rays: 2.0, more_rays: [0.0; 7] };
        (v.parts[0], v.parts[3], v.more_rays[3]) = (1.0, 4.0, 1.0);
        let found = plans(&Plans { lens: Plan::OFF, ..Plans::default() }, &v);
        assert_eq!((found.light.count(), found.pixel.count(), found.lens.count()), (2, 1, 0));
        v.parts[0] = 0.0;
        assert_eq!(plans(&Plans::default(), &v).light.count(), 64);
    }
}
