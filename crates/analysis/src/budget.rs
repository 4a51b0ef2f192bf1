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

/// Points of every integral for the fewest rays. With A the variance around the first hit, V that of an integral there
/// and c the rays of one of its points, (A + Σ V/n)(1 + Σ n·c) is least at n = √(V / (c·A)): one camera ray costs 1. A
/// further point of lens or time costs as much as one of the pixel, and gains less.
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

    /// Where the light makes four times the variance of all around it and a point costs one ray, two points are best.
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
