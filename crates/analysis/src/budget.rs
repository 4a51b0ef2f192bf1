//! What will a picture of a given error cost, and which integral is to blame?
//!
//! A pilot of a few samples over the picture says where the errors are and how bright it is. In blocks that stand for
//! the picture ([`crate::estimate`]), [`dapple_integrator::variances()`] splits the variance by effect. From that follow
//! the counts of the distribution tracer that reach a given error with the fewest rays, and from pairs of independent
//! renders of the blocks the error of a given count, for the distribution tracer with random points and for the path
//! tracer as it is set. Independent points have a squared error ∝ 1/n; the path tracer's other points are rendered at two
//! counts, and the line through both in logarithms is followed to the wanted error. *Approximation*: that the rate
//! stays; the interval grows with the distance.

mod pilot;

use crate::estimate::blocks;
use crate::statistics;
use dapple_integrator::camera::Camera;
use dapple_integrator::forecast::present_in;
use dapple_integrator::sampling::{Pattern, Plan};
use dapple_integrator::scene::Scene;
use dapple_integrator::{Combine, Effect, Method, Plans, Settings, Variances};
use pilot::Pilot;

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
    /// Ends of their confidence interval.
    pub samples_ci: [f64; 2],
    /// Rays of the whole picture.
    pub rays: f64,
    /// Seconds of rendering, at the speed of the pilot.
    pub seconds: f64,
    /// With the interval of the samples, and half as much again for the pilot's short time.
    pub seconds_ci: [f64; 2],
}

/// The most points by which one integral is split.
const MOST: f64 = 64.0;

/// Counts of the path tracer's pilot; Sobol points gain evenly over factors of four.
const COUNTS: [u32; 2] = [16, 64];

/// How uncertain it is that a rate stays: one standard deviation of the exponent.
const RATE: f64 = 0.1;

/// How much a short pilot may be off in time.
const SPEED: f64 = 1.5;

/// The budget for a picture of `settings` with relative RMSE `limit`.
pub fn budget(scene: &Scene, camera: &Camera, settings: &Settings, limit: f64, confidence: f64) -> Budget {
    let pilot = Pilot::new(scene, camera, settings);
    let variances = pilot.variances();
    let shares = shares(&variances, &present_in(scene, camera, settings), confidence);
    let tree = Settings { method: Method::Distribution, ..settings.clone() };
    let tree = Settings {
        combine: Combine::Nested,
        secondary: 1,
        plans: plans(&tree.plans, &sum(&variances)),
        ..tree
    };
    let wanted = Wanted { limit, z: statistics::normal(0.5 + 0.5 * confidence) };
    let predictions =
        vec![wanted.path(&pilot, settings), wanted.tree(&pilot, &tree, &present_in(scene, camera, settings))];
    Budget { error_limit: limit, mean: pilot.mean, effects: shares, predictions }
}

/// All blocks together.
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
    let z = statistics::normal(0.5 + 0.5 * confidence);
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

/// The error that is to be reached.
struct Wanted {
    limit: f64,
    /// Standard deviations to the ends of an interval.
    z: f64,
}

impl Wanted {
    /// Sum over three channels of the mean squared error.
    fn square(&self, mean: f64) -> f64 {
        3.0 * (self.limit * mean).powi(2)
    }

    /// The path tracer with the settings' points.
    fn path(&self, pilot: &Pilot<'_>, settings: &Settings) -> Prediction {
        let path = Settings { method: Method::Path, ..settings.clone() };
        let at = |n: u32| pilot.errors(&Settings { spp: Some(n), ..path.clone() });
        let pairs: Vec<[f64; 2]> =
            at(COUNTS[0]).into_iter().zip(at(COUNTS[1])).map(|(a, b)| [a, b]).collect();
        let target = self.square(pilot.mean);
        let log_n = |pairs: &[[f64; 2]]| {
            let n = pilot.chosen() as f64 / pairs.len().max(1) as f64;
            let [a, b] = [0, 1].map(|i| n * pairs.iter().map(|p| p[i]).sum::<f64>());
            follow([a, b], target, path.pattern).0
        };
        let [a, b] = [0, 1].map(|i| pairs.iter().map(|p| p[i]).sum::<f64>());
        let (middle, rate) = follow([a, b], target, path.pattern);
        let reach =
            if path.pattern == Pattern::Random { 0.0 } else { libm::log(b / target) / (rate * rate) * RATE };
        let error = libm::hypot(jackknife(&pairs, &log_n), reach);
        let samples = [middle, middle - self.z * error, middle + self.z * error].map(libm::exp);
        let options =
            format!("--method path --pattern {} --spp {:.0}", path.pattern, samples[0].ceil().max(1.0));
        prediction("path", options, samples, pilot.path_cost)
    }

    /// The distribution tracer with random points, as many over the pixel as it takes.
    fn tree(&self, pilot: &Pilot<'_>, settings: &Settings, present: &[Effect]) -> Prediction {
        const N: u32 = 4;
        let pixel = |n: u32| {
            let plan =
                if settings.plans.is_off(Effect::Pixel) { Plan::OFF } else { Plan::new(n, Pattern::Random) };
            Settings { plans: Plans { pixel: plan, ..settings.plans }, ..settings.clone() }
        };
        let errors = pilot.errors(&pixel(N));
        let target = self.square(pilot.mean);
        let log_n = |errors: &[f64]| {
            let n = pilot.chosen() as f64 / errors.len().max(1) as f64;
            libm::log(f64::from(N) * n * errors.iter().sum::<f64>() / target)
        };
        let (middle, error) = (log_n(&errors), jackknife(&errors, &log_n));
        let samples = [middle, middle - self.z * error, middle + self.z * error].map(libm::exp);
        let mut options = "--method distribution".to_string();
        for (effect, name) in Effect::ALL {
            let count = settings.plans.of(effect).count();
            options += &match (effect, count) {
                (Effect::Pixel, 1..) => format!(" --pixel {:.0}:random", samples[0].ceil().max(1.0)),
                (_, 0) => format!(" --{name} 0"),
                _ if present.contains(&effect) => format!(" --{name} {count}:random"),
                _ => String::new(),
            };
        }
        prediction("distribution", options, samples, pilot.cost(&pixel(1)))
    }
}

/// The logarithm of the count at which squared errors that are `a` and `b` at [`COUNTS`] come down to `target`, and the
/// exponent by which they fall.
fn follow([a, b]: [f64; 2], target: f64, pattern: Pattern) -> (f64, f64) {
    let counts = COUNTS.map(f64::from);
    if pattern == Pattern::Random {
        return (libm::log(0.5 * (a * counts[0] + b * counts[1]) / target), 1.0);
    }
    let rate = (libm::log(a / b) / libm::log(counts[1] / counts[0])).clamp(0.75, 1.75);
    (libm::log(counts[1]) + libm::log(b / target) / rate, rate)
}

/// `cost`: rays and seconds of one sample of every pixel.
fn prediction(method: &str, options: String, [n, low, high]: [f64; 3], cost: (f64, f64)) -> Prediction {
    Prediction {
        method: method.into(),
        options,
        samples: n,
        samples_ci: [low, high],
        rays: n * cost.0,
        seconds: n * cost.1,
        seconds_ci: [low * cost.1 / SPEED, high * cost.1 * SPEED],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_followed() {
        for (rate, pattern) in [(1.0, Pattern::Random), (1.0, Pattern::Sobol), (1.5, Pattern::Sobol)] {
            let v = |n: f64| 7.0 * n.powf(-rate);
            let (log_n, found) = follow([v(16.0), v(64.0)], v(1000.0), pattern);
            assert!((log_n - 1000f64.ln()).abs() < 1e-9 && (found - rate).abs() < 1e-9);
        }
    }

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
