//! Means and confidence intervals over a few independent measurements.
//!
//! Intervals are Student's, over independent repetitions (seeds). Quantities that are ratios or span orders of
//! magnitude — errors, times, efficiencies — are averaged as logarithms, so that an interval never contains negative
//! values and the intervals of a ratio and of its inverse agree.

/// A value with its confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Whether `x` lies in the interval.
    pub fn contains(&self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }

    /// Whether the interval of a positive quantity is meaningful: its ends are at most a factor [`WIDEST`] apart. The
    /// interval of a single repetition, which is unbounded, is not.
    pub fn is_known(&self) -> bool {
        self.low > 0.0 && self.high <= WIDEST * self.low
    }

    /// Lower and upper end, if the interval of a positive quantity is meaningful.
    pub fn known_ends(&self) -> Option<[f64; 2]> {
        self.is_known().then_some([self.low, self.high])
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self { value: f(self.value), low: f(self.low), high: f(self.high) }
    }
}

/// Default confidence of intervals.
pub const CONFIDENCE: f64 = 0.95;

/// Largest ratio of the ends of an interval that is reported. A quantity that may be ten times larger or smaller than
/// its estimate counts as unknown.
pub const WIDEST: f64 = 100.0;

/// The mean of independent values ± t·s/√k. A single value has an unbounded interval. `None` without values or if one
/// is not finite.
pub fn mean(values: &[f64], confidence: f64) -> Option<Interval> {
    let k = values.len() as f64;
    if values.is_empty() || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let value = values.iter().sum::<f64>() / k;
    let squares = values.iter().map(|v| (v - value) * (v - value)).sum::<f64>();
    let reach = match values.len() {
        1 => f64::INFINITY,
        n => student(0.5 + 0.5 * confidence, (n - 1) as f64) * (squares / (k - 1.0) / k).sqrt(),
    };
    Some(Interval { value, low: value - reach, high: value + reach })
}

/// The geometric mean of positive values, with the interval of the mean of their logarithms. `None` if a value is not
/// positive.
pub fn geometric_mean(values: &[f64], confidence: f64) -> Option<Interval> {
    if values.iter().any(|v| *v <= 0.0) {
        return None;
    }
    let logs: Vec<f64> = values.iter().map(|v| libm::log(*v)).collect();
    mean(&logs, confidence).map(|interval| interval.map(libm::exp))
}

/// The middle value, or the mean of the two middle ones; `None` without values.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    (n > 0).then(|| 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]))
}

/// The p-quantile of Student's distribution with `degrees` of freedom, 0 < p < 1, rounded to 1e-9 of its magnitude, so
/// that decisions do not depend on the machine's logarithm.
pub fn student(p: f64, degrees: f64) -> f64 {
    let quantile = bisected(p, |t| student_below(t, degrees));
    let scale = 1e9 / f64::max(1.0, quantile.abs());
    (quantile * scale).round() / scale
}

/// The p-quantile of the normal distribution, 0 < p < 1.
pub fn normal(p: f64) -> f64 {
    bisected(p, |z| 1.0 - 0.5 * libm::erfc(z * std::f64::consts::FRAC_1_SQRT_2))
}

/// The quantile of a symmetric distribution whose cumulative probability at t ≥ 0 is `below(t)`, to 1e-12.
fn bisected(p: f64, below: impl Fn(f64) -> f64) -> f64 {
    if p < 0.5 {
        return -bisected(1.0 - p, below);
    }
    let (mut low, mut high) = (0.0, 1.0);
    while below(high) < p && high < 1e12 {
        high *= 2.0;
    }
    while high - low > 1e-12 * f64::max(1.0, high) {
        let middle = 0.5 * (low + high);
        if below(middle) < p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// P(T ≤ t), t ≥ 0: 1 − ½ I_x(ν/2, ½) with x = ν/(ν + t²) and the regularised incomplete beta function I.
fn student_below(t: f64, degrees: f64) -> f64 {
    1.0 - 0.5 * statrs::function::beta::beta_reg(0.5 * degrees, 0.5, degrees / (degrees + t * t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_testkit::Rng;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (p, degrees, t) in [
            (0.975, 1.0, 12.706_204_736),
            (0.975, 4.0, 2.776_445_105),
            (0.975, 9.0, 2.262_157_163),
            (0.95, 2.0, 2.919_985_580),
            (0.995, 30.0, 2.749_995_654),
            (0.025, 4.0, -2.776_445_105),
        ] {
            assert!((student(p, degrees) - t).abs() < 1e-8, "{p} {degrees}: {}", student(p, degrees));
        }
        assert!((normal(0.975) - 1.959_963_985).abs() < 1e-7, "{}", normal(0.975));
        assert!(student(0.5, 3.0).abs() < 1e-9);
    }

    #[test]
    fn intervals_by_hand() {
        let found = mean(&[1.0, 2.0, 3.0], 0.95).unwrap();
        let reach = 4.302_652_73 / 3f64.sqrt();
        assert!((found.low - (2.0 - reach)).abs() < 1e-7 && (found.high - (2.0 + reach)).abs() < 1e-7);
        let ratio = geometric_mean(&[0.5, 2.0], 0.95).unwrap();
        assert!((ratio.value - 1.0).abs() < 1e-15 && (ratio.low * ratio.high - 1.0).abs() < 1e-9);
        assert_eq!(mean(&[], 0.95), None);
        assert_eq!(mean(&[1.0, f64::NAN], 0.95), None);
        assert_eq!(geometric_mean(&[1.0, 0.0], 0.95), None);
        assert_eq!(mean(&[7.0], 0.95).unwrap().high, f64::INFINITY);
        assert_eq!(median(&[3.0, 1.0, 2.0, 9.0]), Some(2.5));
    }

    #[test]
    fn wide_intervals_are_not_known() {
        let ends = |low: f64, high: f64| Interval { value: 1.0, low, high }.known_ends();
        assert_eq!(ends(0.1, 10.0), Some([0.1, 10.0]));
        assert_eq!(ends(0.1, 10.1), None);
        assert_eq!(ends(0.0, 1.0), None);
        assert_eq!(mean(&[7.0], 0.95).unwrap().known_ends(), None);
        assert_eq!(ends(f64::NAN, f64::NAN), None);
    }

    /// 95 % of the intervals of five normal values contain the truth, within 4 standard errors of 4000 trials.
    #[test]
    fn intervals_hold_what_they_promise() {
        let mut rng = Rng::new(3);
        let one = |rng: &mut Rng| mean(&[0; 5].map(|_| 1.0 + rng.normal()), 0.95).unwrap().contains(1.0);
        let held = (0..4000).filter(|_| one(&mut rng)).count() as f64 / 4000.0;
        assert!((held - 0.95).abs() < 4.0 * (0.95 * 0.05 / 4000f64).sqrt(), "{held}");
    }
}
