//! Upper bounds of the error contributed by light that no sample has found.
//!
//! - Let M bound the deviation of any sample from the mean of its pixel. Then Z = Σ (x − mean)²/M² over all N samples
//!   is a sum of independent numbers in \[0, 1\]. By Chernoff's bound P(Z ≤ z) ≤ exp(−(μ − z + z ln(z/μ))) for its
//!   expectation μ ≥ z [Chernoff 1952], as for a Poisson variable. With confidence 1 − δ the expectation is therefore
//!   not above the μ at which this expression is δ: 3.0 at 95 % if nothing was observed, z + √(6z) + … if much was. The
//!   excess of μ over z is variance that may exist and was not observed, for any distribution of the samples. M comes
//!   from the scene ([`dapple_integrator::peak`]).
//! - Values that fall off gradually, as around the highlight of a rough surface, predict larger ones: from the largest
//!   squared deviations y₁ ≥ y₂ ≥ … ≥ y_K the tail index k is the mean of ln(y_i/y_K) [Hill 1975], the probability of
//!   exceeding y falls as y^(−1/k), and the contribution between y₁ and the bound follows from it. *Approximation*: the
//!   tail continues with the same index.
//! - A sample of more than twice the largest radiance found for the scene shows that the search for it was incomplete.
//!   The tail then counts without a bound.

use super::within::level;
use crate::statistics;
use dapple_integrator::camera::Film;
use dapple_integrator::{Peak, Tail};

/// Minimum number of deviations from which their distribution is estimated.
const FEWEST: usize = 8;

/// Ratio of a sample to the largest radiance found for the scene above which the search counts as incomplete.
const MISSED: f64 = 2.0;

/// Maximum number of path vertices whose contributions are assumed to add up.
const VERTICES: f64 = 16.0;

/// If the samples of a pixel add up to more than this number of the brightest ones, these are not rare in that pixel.
const OFTEN: f64 = 8.0;

/// The kind of light that samples may not have found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hidden {
    /// Emitters that light sampling cannot find.
    Emitters,
    /// Diffuse surfaces close to a light, or onto which light is focused.
    Lit,
    /// The centre of highlights.
    Highlights,
    /// The unknown cause of the brightest samples.
    Outliers,
}

/// The bound of light that no sample has found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unseen {
    /// Relative RMSE that this light may add, with the requested confidence.
    pub error: f64,
    /// The kind of light that contributes most to it.
    pub what: Hidden,
    /// The brightest single sample it can produce, relative to the mean radiance of the image.
    pub times: f64,
}

/// Bounds the error contributed by unseen light from an image, its largest differences of samples, and the maximum
/// radiance of a sample of the scene. `None` with fewer than two samples in some pixel, without light, or if a variance
/// is not finite.
pub fn unseen(film: &Film, tail: &Tail, peak: &Peak, confidence: f64) -> Option<Unseen> {
    let seen = Observed::new(film, tail, confidence)?;
    let brightest = (seen.largest.first().copied().unwrap_or_default() / 3.0).sqrt();
    // A sample is the sum over the vertices of its path, each of which may be about as bright as the image.
    let known = MISSED * peak.most() + VERTICES * seen.level;
    let missed = if brightest > known { brightest } else { 0.0 };
    let outliers = if missed > 0.0 { seen.beyond(f64::INFINITY) } else { 0.0 };
    // An observed value is possible, and so bounds M from below.
    let sharp = peak.emitter.max(peak.lit).max(missed);
    let highlight = peak.highlight;
    let highlights = if highlight <= sharp {
        0.0
    } else {
        seen.unmet(highlight).min(seen.beyond(3.0 * highlight * highlight))
    };
    let what = if peak.emitter >= peak.lit { Hidden::Emitters } else { Hidden::Lit };
    let parts = [
        (seen.unmet(sharp), what, sharp),
        (highlights, Hidden::Highlights, highlight),
        (outliers, Hidden::Outliers, brightest),
    ];
    let squares: f64 = parts.iter().map(|part| part.0).sum();
    let (_, what, radiance) = parts.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Unseen { error: seen.error(squares), what, times: radiance / seen.level })
}

/// Statistics of the samples of an image.
struct Observed {
    pixels: f64,
    /// Sample count of the pixel with the fewest samples.
    least: f64,
    /// Mean radiance.
    level: f64,
    /// Sums of squared deviations over the samples and channels of each pixel.
    squares: Vec<f64>,
    /// The largest squared deviations of single samples from their neighbours or from the mean in decreasing order.
    largest: Vec<f64>,
    confidence: f64,
}

impl Observed {
    fn new(film: &Film, tail: &Tail, confidence: f64) -> Option<Self> {
        let rect = film.rect();
        let counts: Vec<f64> = (rect.y0..rect.y1)
            .flat_map(|y| (rect.x0..rect.x1).map(move |x| film.count(x, y) as f64))
            .collect();
        let variance = film.variance();
        let sum = |(v, n): (&glam::Vec3, &f64)| v.as_dvec3().element_sum() * n * (n - 1.0);
        let squares: Vec<f64> = variance.pixels.iter().zip(&counts).map(sum).collect();
        let least = counts.iter().copied().fold(f64::INFINITY, f64::min);
        let level = level(film.mean().mean());
        let pixels = rect.area() as f64;
        let known = least >= 2.0 && least.is_finite() && level > 0.0 && squares.iter().all(|s| s.is_finite());
        let mut tail = tail.clone();
        film.unpaired().for_each(|square| tail.add(square));
        known.then(|| Self { pixels, least, level, squares, largest: tail.sorted(), confidence })
    }

    /// The relative RMSE that corresponds to additional squared deviations of the sum `squares`. In the worst case all
    /// of them are in the pixels with the fewest samples.
    fn error(&self, squares: f64) -> f64 {
        (squares / (3.0 * self.pixels)).sqrt() / (self.least * self.level)
    }

    /// Squared deviations that may be missing if no sample is brighter than `most`. Pixels that are hit by such samples
    /// repeatedly, as along the edges of a lamp, have a known variance; they are left to the estimate from the samples.
    fn unmet(&self, most: f64) -> f64 {
        let square = 3.0 * most * most;
        if square <= 0.0 {
            return 0.0;
        }
        if most <= self.level {
            // Not brighter than the mean of the image, hence not rare.
            return square * self.more(0.0);
        }
        let seen = self.squares.iter().filter(|s| **s < OFTEN * square).sum::<f64>() / square;
        let at_once = square * self.more(seen);
        let Some(&largest) = self.largest.first().filter(|y| 4.0 * **y <= square) else { return at_once };
        // None of the brightest values was observed, and the observed ones are small: two kinds, each with a bound of
        // its own.
        let small = self.squares.iter().sum::<f64>() / largest;
        at_once.min(square * self.more(0.0) + largest * self.more(small))
    }

    /// Maximum excess of the expectation of a sum of numbers in \[0, 1\] over the observed sum.
    fn more(&self, seen: f64) -> f64 {
        largest_expectation(seen, 1.0 - self.confidence) - seen
    }

    /// Squared deviations expected between the largest one observed and `most`, extrapolated by the tail index.
    fn beyond(&self, most: f64) -> f64 {
        let (n, [first, .., last]) = (self.largest.len(), &self.largest[..]) else { return 0.0 };
        if n < FEWEST || most <= *first {
            return if n < FEWEST { f64::INFINITY } else { 0.0 };
        }
        let falls = (n - 1) as f64;
        let index = self.largest[..n - 1].iter().map(|y| libm::log(y / last)).sum::<f64>() / falls;
        // The standard deviation of the index is the index over the root of the count.
        let index = index * (1.0 + statistics::normal(self.confidence) / falls.sqrt());
        first * tail_sum(1.0 / index.max(1e-3), most / first)
    }
}

/// ∫ y dF from 1 to `most` for a distribution in which 1 is exceeded once on average and the probability falls as
/// y^(−power); the probability above `most` is concentrated at `most`.
fn tail_sum(power: f64, most: f64) -> f64 {
    if most.is_infinite() {
        return if power > 1.0 { power / (power - 1.0) } else { f64::INFINITY };
    }
    let (logarithm, rest) = (libm::log(most), 1.0 - power);
    let grown = libm::exp(rest * logarithm);
    let between = if (rest * logarithm).abs() < 1e-6 { logarithm } else { (grown - 1.0) / rest };
    power * between + grown
}

/// The largest expectation of a sum of independent numbers in \[0, 1\] for which the probability of a sum of at most
/// `seen` is `missed`.
fn largest_expectation(seen: f64, missed: f64) -> f64 {
    let wanted = -libm::log(missed);
    let exponent = |mu: f64| if seen > 0.0 { mu - seen + seen * libm::log(seen / mu) } else { mu };
    let (mut low, mut high) = (seen, seen + 2.0 * wanted + (2.0 * seen * wanted).sqrt());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if exponent(middle) < wanted { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_testkit::Rng;

    /// The probability of at most `n` events of a Poisson variable is Σ e^−μ μ^k/k!, which is not above Chernoff's
    /// bound.
    #[test]
    fn expectations_are_bounded() {
        assert!((largest_expectation(0.0, 0.05) - 20f64.ln()).abs() < 1e-9);
        for n in [1, 3, 10, 100] {
            let mu = largest_expectation(f64::from(n), 0.05);
            let mut term = (-mu).exp();
            let mut chance = term;
            for k in 1..=n {
                term *= mu / f64::from(k);
                chance += term;
            }
            assert!(chance <= 0.05 && chance > 0.004, "{n}: {mu} {chance}");
            let exponent = mu - f64::from(n) + f64::from(n) * (f64::from(n) / mu).ln();
            assert!((exponent - 20f64.ln()).abs() < 1e-6);
        }
        assert!(largest_expectation(1e9, 0.05) < 1.0001e9);
    }

    /// The integral of a Pareto distribution between its largest observed value and a bound, by quadrature in the
    /// logarithm.
    #[test]
    fn tails_are_added_up() {
        for (power, most) in [(0.5, 100.0), (1.0, 50.0), (2.0, 10.0), (1.3, 1e4)] {
            let steps = 200_000;
            let h = f64::ln(most) / f64::from(steps);
            let density = |t: f64| power * ((1.0 - power) * t).exp();
            let between: f64 = (0..steps).map(|i| h * density((f64::from(i) + 0.5) * h)).sum();
            let all = between + f64::powf(most, 1.0 - power);
            let found = tail_sum(power, most);
            assert!((found / all - 1.0).abs() < 1e-6, "{power} {most}: {found} {all}");
        }
        assert_eq!(tail_sum(2.0, f64::INFINITY), 2.0);
        assert_eq!(tail_sum(0.9, f64::INFINITY), f64::INFINITY);
    }

    /// For events of value 1 and probability p among N samples, N·p exceeds the bound derived from the number of
    /// observed events in at most 5 % of the trials, for few events and for many.
    #[test]
    fn rare_events_are_within_what_may_be_there() {
        let mut rng = Rng::new(11);
        for expected in [0.5, 3.5, 12.0, 80.0] {
            let (n, trials) = (2000, 1000);
            let missed = (0..trials).filter(|_| {
                let met = (0..n).filter(|_| rng.f64() < expected / f64::from(n)).count();
                largest_expectation(met as f64, 0.05) < expected
            });
            assert!(missed.count() <= 50);
        }
    }

    /// Deviations that fall off as 1/y² contribute beyond the largest value on average about twice that value.
    #[test]
    fn a_tail_tells_what_is_beyond_it() {
        let mut rng = Rng::new(4);
        let mut sum = 0.0;
        for _ in 0..400 {
            let mut tail = Tail::default();
            (0..4000).for_each(|_| tail.add(1.0 / rng.f64().max(1e-12).sqrt()));
            let largest = tail.sorted();
            let seen = Observed {
                pixels: 1.0,
                least: 2.0,
                level: 1.0,
                squares: vec![1.0],
                largest,
                confidence: 0.5,
            };
            sum += seen.beyond(f64::INFINITY) / seen.largest[0] / 400.0;
        }
        assert!((1.9..2.3).contains(&sum), "{sum}");
    }
}
