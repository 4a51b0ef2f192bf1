//! Prediction of the cost of an image of given error, and of the share of each effect in the variance.
//!
//! A pilot render of a few samples locates the errors and measures the mean radiance. In blocks that represent the
//! image ([`crate::estimate`]), [`dapple_integrator::variances()`] splits the variance by effect. From this follow the
//! sample counts of the distribution tracer that reach a given error with the fewest rays, and from pairs of
//! independent renders of the blocks the error at a given count, for the distribution tracer with random points and for
//! the path tracer with its settings. Independent points have a squared error ∝ 1/n. The other patterns of the path
//! tracer are rendered at two counts, and the line through both in logarithms is extrapolated to the requested error.
//! *Approximation*: the rate of convergence is assumed to be constant; the interval grows with the distance of the
//! extrapolation.
//!
//! All of this is done in independent groups of blocks, whose differences give the confidence intervals. While an
//! interval is wide, the pilot continues with twice as many groups, or with larger sample counts, closer to the
//! requested ones. It is limited by a number of rays, so that the same call gives the same result on every machine, or
//! by a time, if one is given. An interval that is still unknown at the end is not reported.

mod pilot;
mod shares;
mod wanted;

pub use shares::Share;
pub use wanted::{NARROW, Prediction};

use dapple_integrator::camera::Camera;
use dapple_integrator::forecast::present_in;
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::scene::Scene;
use dapple_integrator::{Combine, Effect, MethodKind, SampleSets, Settings, Variances};
use pilot::Pilot;
use shares::{shares, sum};
use std::time::{Duration, Instant};
use wanted::Wanted;

/// The shares of the effects in the variance, and the predicted costs.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Budget {
    /// The requested relative RMSE.
    pub error_limit: f64,
    /// Mean radiance of the image.
    pub mean: f64,
    /// Effects that are present in the scene, in nesting order; their shares add up to 1.
    pub effects: Vec<Share>,
    /// One prediction per method.
    pub predictions: Vec<Prediction>,
}

/// Maximum number of points per integral.
const MOST: f64 = 64.0;

/// Predicts the budget of an image with `settings` and relative RMSE `limit`. With `time`, a pilot with wide intervals
/// continues while its next step is expected to end within that time; its first steps are taken in any case.
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

/// Number of points of every integral that minimises the rays. With A the variance around the first hit, V that of an
/// integral there and c the rays of one of its points, (A + Σ V/n)(1 + Σ n·c) is minimal at n = √(V / (c·A)), where one
/// camera ray costs 1. A further point of lens or time costs as much as one of the pixel, and gains less.
fn plans(set: &SampleSets, v: &Variances) -> SampleSets {
    let mut plans = *set;
    let rays = v.rays.max(f64::MIN_POSITIVE);
    let around: f64 = v.parts[..3].iter().sum();
    let camera = rays - v.more_rays[3..].iter().sum::<f64>();
    for (i, (effect, _)) in Effect::ALL.iter().enumerate().filter(|(_, (e, _))| !set.is_off(*e)) {
        let (part, cost) = (v.parts[i], v.more_rays[i] / camera.max(1e-3 * rays));
        let n = if i < 3 || part <= 0.0 { 1.0 } else { (part / (cost * around)).sqrt() };
        let n = if n.is_nan() { 1.0 } else { n.round().clamp(1.0, MOST) };
        *plans.of_mut(*effect) = SampleSet::new(n as u32, Pattern::Random);
    }
    plans
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If the variance of light sampling is four times that of the rest and a point costs one ray, two points are
    /// optimal.
    #[test]
    fn counts_follow_variance_and_cost() {
        let mut v = Variances { parts: [0.0; 7], rest: 0.0, mean: 1.0, rays: 2.0, more_rays: [0.0; 7] };
        (v.parts[0], v.parts[3], v.more_rays[3]) = (1.0, 4.0, 1.0);
        let found = plans(&SampleSets { lens: SampleSet::OFF, ..SampleSets::default() }, &v);
        assert_eq!((found.light.count(), found.pixel.count(), found.lens.count()), (2, 1, 0));
        v.parts[0] = 0.0;
        assert_eq!(plans(&SampleSets::default(), &v).light.count(), 64);
    }
}
