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
//! of rays, so that the same call says the same on every machine, and time, if the settings grant it some. An interval that
//! is not known even then is not told.

mod pilot;

use crate::statistics;
use dapple_integrator::camera::Camera;
use dapple_integrator::forecast::present;
use dapple_integrator::sampling::{Pattern, Plan};
use dapple_integrator::scene::Scene;
use dapple_integrator::{Combine, Effect, Method, Plans, Settings, Variances};
use pilot::Pilot;
use std::time::{Duration, Instant};

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

/// Counts of the path tracer's pilot at first; Sobol points gain evenly over factors of four.
const COUNTS: [u32; 2] = [16, 64];

/// Points over the pixel of the distribution tracer's pilot.
const POINTS: u32 = 4;

/// Groups at first: there are twice as many as long as intervals are wide.
const GROUPS: u32 = 8;

/// No more groups than this.
const MOST_GROUPS: u32 = 1024;

/// The pilot goes on until the ends of an interval are at most this factor apart, or …
pub const NARROW: f64 = 4.0;

/// … it has taken so many rays for each of its parts.
const RAYS: f64 = 8e6;

/// Half the width of the interval of a share from which on no more groups are rendered for the shares.
const SHARE: f64 = 0.1;

/// How uncertain it is that a rate stays: one standard deviation of the exponent.
const RATE: f64 = 0.1;

/// How far counts of points that are not independent are off the line, one standard deviation of their logarithm: between
/// powers of two Sobol points have gained less than the line says.
const UNEVEN: f64 = 0.1;

/// How much a short pilot may be off in time.
const SPEED: f64 = 1.5;

/// The budget for a picture of `settings` with relative RMSE `limit`. With `time`, a pilot whose intervals are wide goes on
/// for so long.
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
    let present = present(scene, camera);
    let wanted = Wanted { limit, confidence, start, time };
    let variances = wanted.variances(&pilot, &present);
    let shares = shares(&variances, &present, confidence);
    let tree = Settings { method: Method::Distribution, ..settings.clone() };
    let tree = Settings {
        combine: Combine::Nested,
        secondary: 1,
        plans: plans(&tree.plans, &sum(&variances)),
        ..tree
    };
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

/// The error that is to be reached, and how sure one wants to be.
struct Wanted {
    limit: f64,
    confidence: f64,
    start: Instant,
    time: Option<Duration>,
}

/// The logarithm of a count, and its standard errors.
#[derive(Clone, Copy, Debug)]
struct Found {
    log_n: f64,
    /// From what the groups differ by, in standard errors that reach to the end of the interval.
    chance: f64,
    /// From how far a line was followed, likewise.
    distance: f64,
}

impl Found {
    fn width(&self) -> f64 {
        libm::hypot(self.chance, self.distance)
    }

    fn is_narrow(&self) -> bool {
        2.0 * self.width() <= libm::log(NARROW)
    }

    /// The count and the ends of its interval.
    fn samples(&self) -> [f64; 3] {
        [self.log_n, self.log_n - self.width(), self.log_n + self.width()].map(libm::exp)
    }
}

impl Wanted {
    /// Sum over three channels of the mean squared error.
    fn square(&self, mean: f64) -> f64 {
        3.0 * (self.limit * mean).powi(2)
    }

    /// Whether a pilot that took `rays` so far may take as many again: they are few, or there is time.
    fn may_go_on(&self, rays: f64) -> bool {
        2.0 * rays <= RAYS || self.time.is_some_and(|time| 2 * self.start.elapsed() <= time)
    }

    /// From errors of groups: the standard errors of the squared error that is wanted are those of the mean radiance.
    fn width(&self, pilot: &Pilot<'_>, rate: f64, groups: usize, jackknifed: f64) -> f64 {
        let of_mean = statistics::normal(0.5 + 0.5 * self.confidence) * 2.0 * pilot.mean_error / rate;
        libm::hypot(reach(groups, self.confidence) * jackknifed, of_mean)
    }

    /// Of groups, what effects make of the variance: of so many that shares are known.
    fn variances(&self, pilot: &Pilot<'_>, present: &[Effect]) -> Vec<Variances> {
        let mut found = pilot.variances(0..GROUPS);
        loop {
            let shares = shares(&found, present, self.confidence);
            let wide = shares.iter().any(|s| s.share_ci[1] - s.share_ci[0] > 2.0 * SHARE);
            let rays = found.iter().map(|v| v.rays).sum::<f64>() * pilot.group_area();
            let groups = found.len() as u32;
            if !wide || groups >= MOST_GROUPS || !self.may_go_on(rays) {
                return found;
            }
            found.extend(pilot.variances(groups..2 * groups));
        }
    }

    /// The path tracer with the settings' points.
    fn path(&self, pilot: &Pilot<'_>, settings: &Settings) -> Prediction {
        let path = Settings { method: Method::Path, ..settings.clone() };
        let found = self.path_found(pilot, &path);
        let options = format!(
            "--method path --pattern {} --spp {:.0}",
            path.pattern,
            found.samples()[0].ceil().max(1.0)
        );
        prediction("path", options, found, pilot.path_cost)
    }

    fn path_found(&self, pilot: &Pilot<'_>, path: &Settings) -> Found {
        let mut counts = COUNTS;
        let mut pairs: Vec<[f64; 2]> = Vec::new();
        let per_sample = pilot.path_cost.0 / pilot.area() * pilot.group_area();
        let rays = |counts: [u32; 2], groups: u32| {
            2.0 * f64::from(counts[0] + counts[1]) * f64::from(groups) * per_sample
        };
        let at = |counts: [u32; 2], groups: std::ops::Range<u32>| -> Vec<[f64; 2]> {
            let [a, b] =
                counts.map(|n| pilot.errors(&Settings { spp: Some(n), ..path.clone() }, groups.clone()));
            a.into_iter().zip(b).map(|(a, b)| [a, b]).collect()
        };
        loop {
            let groups = pairs.len() as u32;
            pairs.extend(at(counts, groups..(2 * groups).max(GROUPS)));
            let found = self.followed(pilot, counts, &pairs, path.pattern);
            let taken = rays(counts, pairs.len() as u32);
            let nearer = counts.map(|n| 4 * n);
            let far = found.distance > found.chance && found.log_n > libm::log(f64::from(counts[1]));
            if found.is_narrow() || pairs.len() as u32 >= MOST_GROUPS {
                return found;
            }
            if far && self.may_go_on(0.5 * rays(nearer, GROUPS)) {
                (counts, pairs) = (nearer, Vec::new());
            } else if !self.may_go_on(taken) {
                return found;
            }
        }
    }

    /// The count at which the line through errors at two counts comes down to the wanted one.
    fn followed(&self, pilot: &Pilot<'_>, counts: [u32; 2], pairs: &[[f64; 2]], pattern: Pattern) -> Found {
        let target = self.square(pilot.mean);
        let means = |pairs: &[[f64; 2]]| {
            [0, 1].map(|i| pairs.iter().map(|p| p[i]).sum::<f64>() / pairs.len().max(1) as f64)
        };
        let log_n = |pairs: &[[f64; 2]]| follow(counts, means(pairs), target, pattern).0;
        let (middle, rate) = follow(counts, means(pairs), target, pattern);
        let beyond = libm::log(means(pairs)[1] / target);
        let distance = match pattern {
            Pattern::Random => 0.0,
            _ => libm::hypot(beyond.abs() / (rate * rate) * RATE, UNEVEN),
        };
        Found {
            log_n: middle,
            chance: self.width(pilot, rate, pairs.len(), jackknife(pairs, &log_n)),
            distance: statistics::normal(0.5 + 0.5 * self.confidence) * distance,
        }
    }

    /// The distribution tracer with random points, as many over the pixel as it takes.
    fn tree(&self, pilot: &Pilot<'_>, settings: &Settings, present: &[Effect]) -> Prediction {
        let pixel_is_off = settings.plans.is_off(Effect::Pixel);
        let pixel = |n: u32| {
            let plan = if pixel_is_off { Plan::OFF } else { Plan::new(n, Pattern::Random) };
            Settings { plans: Plans { pixel: plan, ..settings.plans }, ..settings.clone() }
        };
        let cost = pilot.cost(&pixel, pixel_is_off);
        let target = self.square(pilot.mean);
        let log_n = |errors: &[f64]| {
            let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
            libm::log(f64::from(POINTS) * mean / target)
        };
        let per_group = 2.0 * f64::from(POINTS) * cost.0 / pilot.area() * pilot.group_area();
        let mut errors = pilot.errors(&pixel(POINTS), 0..GROUPS);
        let found = loop {
            let groups = errors.len() as u32;
            let chance = self.width(pilot, 1.0, errors.len(), jackknife(&errors, &log_n));
            let found = Found { log_n: log_n(&errors), chance, distance: 0.0 };
            if found.is_narrow() || groups >= MOST_GROUPS || !self.may_go_on(f64::from(groups) * per_group) {
                break found;
            }
            errors.extend(pilot.errors(&pixel(POINTS), groups..2 * groups));
        };
        let samples = found.samples()[0].ceil().max(1.0);
        let mut options = "--method distribution".to_string();
        for (effect, name) in Effect::ALL {
            let count = settings.plans.of(effect).count();
            options += &match (effect, count) {
                (Effect::Pixel, 1..) => format!(" --pixel {samples:.0}:random"),
                (_, 0) => format!(" --{name} 0"),
                _ if present.contains(&effect) => format!(" --{name} {count}:random"),
                _ => String::new(),
            };
        }
        prediction("distribution", options, found, cost)
    }
}

/// The logarithm of the count at which squared errors that are `a` and `b` at two counts come down to `target`, and the
/// exponent by which they fall.
fn follow(counts: [u32; 2], [a, b]: [f64; 2], target: f64, pattern: Pattern) -> (f64, f64) {
    let counts = counts.map(f64::from);
    if pattern == Pattern::Random {
        return (libm::log(0.5 * (a * counts[0] + b * counts[1]) / target), 1.0);
    }
    let rate = (libm::log(a / b) / libm::log(counts[1] / counts[0])).clamp(0.75, 1.75);
    (libm::log(counts[1]) + libm::log(b / target) / rate, rate)
}

/// `cost`: rays and seconds of one sample of every pixel.
fn prediction(method: &str, options: String, found: Found, cost: (f64, f64)) -> Prediction {
    let [n, low, high] = found.samples();
    let known = statistics::Interval { value: n, low, high }.known_ends();
    Prediction {
        method: method.into(),
        options,
        samples: n,
        samples_ci: known,
        rays: n * cost.0,
        seconds: n * cost.1,
        seconds_ci: known.map(|[low, high]| [low * cost.1 / SPEED, high * cost.1 * SPEED]),
        is_narrow: found.is_narrow(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_followed() {
        for (rate, pattern) in [(1.0, Pattern::Random), (1.0, Pattern::Sobol), (1.5, Pattern::Sobol)] {
            let v = |n: f64| 7.0 * n.powf(-rate);
            let (log_n, found) = follow([16, 64], [v(16.0), v(64.0)], v(1000.0), pattern);
            assert!((log_n - 1000f64.ln()).abs() < 1e-9 && (found - rate).abs() < 1e-9);
        }
    }

    #[test]
    fn wide_intervals_are_not_told() {
        let of = |chance: f64| {
            prediction("path", String::new(), Found { log_n: 5.0, chance, distance: 0.0 }, (1.0, 1.0))
        };
        let (narrow, wide, unknown) = (of(0.5), of(2.0), of(2.4));
        assert!(narrow.is_narrow && !wide.is_narrow && wide.samples_ci.is_some());
        assert_eq!((unknown.samples_ci, unknown.seconds_ci, of(f64::NAN).samples_ci), (None, None, None));
        assert!(!of(f64::INFINITY).is_narrow);
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
