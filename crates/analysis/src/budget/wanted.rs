//! The sample counts that reach a requested error, with confidence intervals.

use super::pilot::Pilot;
use super::shares::{jackknife, reach, shares};
use crate::statistics;
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::{Effect, MethodKind, SampleSets, Settings, Variances};
use std::time::{Duration, Instant};

/// Initial sample counts of the path tracer's pilot; over factors of four Sobol points converge evenly.
const COUNTS: [u32; 2] = [16, 64];

/// Points over the pixel in the distribution tracer's pilot.
const POINTS: u32 = 4;

/// Initial number of groups, which doubles while intervals are wide.
const GROUPS: u32 = 8;

/// Maximum number of groups.
const MOST_GROUPS: u32 = 1024;

/// The pilot ends when the ends of an interval are at most this factor apart, or at the limit of rays.
pub const NARROW: f64 = 4.0;

/// Maximum number of rays of each part of a pilot without a time limit.
const RAYS: f64 = 8e6;

/// Half width of the interval of a share below which no more groups are rendered for the shares.
const SHARE: f64 = 0.1;

/// Uncertainty of the extrapolated rate: one standard deviation of the exponent.
const RATE: f64 = 0.1;

/// Deviation from the line for points that are not independent: one standard deviation of the logarithm of the count.
/// Between powers of two, Sobol points have converged less than the line predicts.
const UNEVEN: f64 = 0.1;

/// Factor by which the time per sample measured in a short pilot may be off.
const SPEED: f64 = 1.5;

/// A predicted render that reaches the requested error.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Prediction {
    /// `path` or `distribution`.
    pub method: String,
    /// The options for `dapple render`.
    pub options: String,
    /// Samples per pixel, or points over the pixel's area.
    pub samples: f64,
    /// Ends of the confidence interval of `samples`; `None` if they are more than a factor [`statistics::WIDEST`]
    /// apart.
    pub samples_ci: Option<[f64; 2]>,
    /// Rays of the whole image.
    pub rays: f64,
    /// Seconds of rendering, at the speed of the pilot.
    pub seconds: f64,
    /// The interval of `seconds`: that of the samples, widened by half for the short time of the pilot.
    pub seconds_ci: Option<[f64; 2]>,
    /// Whether the ends are within a factor of [`NARROW`]; if not, a longer pilot is required.
    pub is_narrow: bool,
}

/// The requested error and confidence, and the time limit of the pilot.
pub(super) struct Wanted {
    pub limit: f64,
    pub confidence: f64,
    pub start: Instant,
    pub time: Option<Duration>,
}

/// The logarithm of a sample count and its uncertainty.
#[derive(Clone, Copy, Debug)]
struct Found {
    log_n: f64,
    /// Half width of the interval due to the variation between groups.
    chance: f64,
    /// Half width of the interval due to the extrapolation.
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
    /// The requested mean squared error, summed over three channels.
    fn square(&self, mean: f64) -> f64 {
        3.0 * (self.limit * mean).powi(2)
    }

    /// Whether a pilot that took `rays` so far may take as many again: time remains, or without a time limit the number
    /// of rays is below the maximum.
    fn may_go_on(&self, rays: f64) -> bool {
        self.time.map_or(2.0 * rays <= RAYS, |time| 2 * self.start.elapsed() <= time)
    }

    /// Half width of the interval of the logarithm of a count, from the jackknifed standard error over groups and from
    /// the standard error of the mean radiance, which determines the requested squared error.
    fn width(&self, pilot: &Pilot<'_>, rate: f64, groups: usize, jackknifed: f64) -> f64 {
        let of_mean = statistics::normal(0.5 + 0.5 * self.confidence) * 2.0 * pilot.mean_error / rate;
        libm::hypot(reach(groups, self.confidence) * jackknifed, of_mean)
    }

    /// The variances by effect of as many groups as the shares require.
    pub fn variances(&self, pilot: &Pilot<'_>, present: &[Effect]) -> Vec<Variances> {
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

    /// The prediction for the path tracer with the pattern of the settings.
    pub fn path(&self, pilot: &Pilot<'_>, settings: &Settings) -> Prediction {
        let path = settings.clone().with_method(MethodKind::Path);
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
            let [a, b] = counts.map(|n| pilot.errors(&path.clone().with_spp(n), groups.clone()));
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

    /// The count at which the line through the errors at two counts reaches the requested error.
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

    /// The prediction for the distribution tracer with random points, varying the number of points over the pixel.
    pub fn tree(&self, pilot: &Pilot<'_>, settings: &Settings, present: &[Effect]) -> Prediction {
        let pixel_is_off = settings.plans.is_off(Effect::Pixel);
        let pixel = |n: u32| {
            let plan = if pixel_is_off { SampleSet::OFF } else { SampleSet::new(n, Pattern::Random) };
            Settings { plans: SampleSets { pixel: plan, ..settings.plans }, ..settings.clone() }
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

/// The logarithm of the count at which squared errors that are `a` and `b` at two counts reach `target`, and the
/// exponent by which they fall.
fn follow(counts: [u32; 2], [a, b]: [f64; 2], target: f64, pattern: Pattern) -> (f64, f64) {
    let counts = counts.map(f64::from);
    if pattern == Pattern::Random {
        return (libm::log(0.5 * (a * counts[0] + b * counts[1]) / target), 1.0);
    }
    let rate = (libm::log(a / b) / libm::log(counts[1] / counts[0])).clamp(0.75, 1.75);
    (libm::log(counts[1]) + libm::log(b / target) / rate, rate)
}

/// The prediction from a count and the `cost` of one sample of every pixel in rays and seconds.
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
}
