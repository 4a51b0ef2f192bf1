//! Error estimates, and the estimate of independent samples from their variance within pixels.

use crate::statistics;
use dapple_integrator::camera::Film;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::{Effect, MethodKind, Settings};

/// The estimated error of an image, as relative RMSE.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// The expected error.
    pub error: f64,
    /// An upper bound of the true error of the image, with the requested confidence.
    pub bound: f64,
}

impl Estimate {
    /// An estimate from the mean squared error, an upper value of it apart from random variation, the relative standard
    /// deviation of the latter combined with that of the true squared error, and the mean radiance. *Approximation*:
    /// the ratio of true to stated squared error is log-normal; sums of a few squares are skewed, and a normal
    /// distribution would give too low a bound.
    pub(super) fn new(mse: f64, high: f64, spread: f64, level: f64, confidence: f64) -> Option<Self> {
        let chance = libm::exp(statistics::normal(confidence) * spread);
        let (error, bound) = (mse.sqrt() / level, (high * chance).sqrt() / level);
        (error.is_finite() && bound.is_finite() && level > 0.0).then_some(Self { error, bound })
    }
}

impl Estimate {
    /// The bound at the confidence `of[1]`, derived from this bound at the confidence `of[0]` by scaling its logarithm.
    pub fn bound_of(&self, of: [f64; 2]) -> f64 {
        let [this, other] = of.map(statistics::normal);
        self.error * libm::pow(self.bound / self.error, other / this)
    }
}

/// Method of estimating the error of a finished render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Variance within pixels, by [`within`].
    Within,
    /// Rendering pixels again, by [`replicate`](super::replicate()).
    Replicate,
    /// None: there is no image, or the points are cell centres, which are equal for every seed, so that their error is
    /// not random.
    None,
}

impl Way {
    /// The method for the sampling patterns of `settings`.
    pub fn of(settings: &Settings) -> Self {
        let grid = |e| settings.plans.of(e).pattern == Pattern::Grid && !settings.plans.is_off(e);
        match (settings.kind(), settings.pattern) {
            _ if !settings.picture => Self::None,
            (MethodKind::Path, Pattern::Random) => Self::Within,
            (MethodKind::Path, Pattern::Grid) => Self::None,
            (MethodKind::Path, _) => Self::Replicate,
            (MethodKind::Distribution, _) if Effect::ALL.iter().any(|(e, _)| grid(*e)) => Self::None,
            (MethodKind::Distribution, _) => Self::Replicate,
        }
    }
}

/// The error of independent samples from their variance within pixels.
pub fn within(film: &Film, confidence: f64) -> Option<Estimate> {
    let variance = film.variance();
    let (sum, spread) = sum_and_spread(variance.pixels.iter().map(|v| v.as_dvec3().element_sum()));
    let mse = sum / (3 * variance.pixels.len()) as f64;
    // One part for the estimate, one for the true error.
    Estimate::new(mse, mse, (2.0 * spread).sqrt(), level(film.mean().mean()), confidence)
}

/// The mean of three channels.
pub(super) fn level(mean: glam::Vec3) -> f64 {
    f64::from(mean.x + mean.y + mean.z) / 3.0
}

/// Sum of `values`, and the square of its relative standard deviation if each value is an independent squared error: Σ
/// v² / (Σ v)², which a few large values make large.
pub(super) fn sum_and_spread(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (sum, squares) = values.fold((0.0, 0.0), |(s, q), v| (s + v, q + v * v));
    (sum, if sum > 0.0 { squares / (sum * sum) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice as many standard deviations: 1.5² in place of 1.5.
    #[test]
    fn surer_bounds_are_wider() {
        let found = Estimate { error: 0.04, bound: 0.06 };
        assert!((found.bound_of([0.95, 0.95]) - 0.06).abs() < 1e-12);
        let twice = [statistics::CONFIDENCE, 0.999_498_54];
        assert!((found.bound_of(twice) - 0.09).abs() < 1e-6, "{}", found.bound_of(twice));
    }
}
