//! Errors of several methods at equal time.
//!
//! A comparison at equal error uses the smallest error that both methods reach, which the slower method reaches only at
//! its last point. At equal time, each method contributes the error it has at that time. Several times are compared,
//! because the order of two methods may depend on the time.

use super::fall::{Curve, Error, Over, logs};
use crate::statistics::{self, Interval};

/// Ratio of successive times.
const STEP: f64 = 4.0;

/// Maximum number of times.
const MOST: usize = 5;

/// Error and efficiency of a method after a given time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EqualCost {
    /// Time in seconds.
    pub cost: f64,
    /// Relative RMSE: geometric mean over seeds.
    pub error: Interval,
    /// Efficiency 1/(MSE · time) divided by that of the first method, both MSEs relative to the squared mean of the
    /// reference. Since the times are equal, this is the inverse ratio of the squared errors. Seeds are paired in
    /// order. `None` for the first method itself, and where the first method has no error at this time.
    pub efficiency: Option<Interval>,
}

/// The relative RMSE at `cost`, interpolated linearly in logarithms between measured points, never extrapolated.
fn error_at(curve: &Curve, over: Over, cost: f64) -> Option<f64> {
    let logs = logs(curve, over, Error::RelativeRmse);
    let wanted = libm::log(cost);
    let pair = logs.windows(2).find(|pair| pair[0].0 <= wanted && wanted <= pair[1].0)?;
    let (a, b) = (pair[0], pair[1]);
    let share = if b.0 > a.0 { (wanted - a.0) / (b.0 - a.0) } else { 0.0 };
    Some(libm::exp(a.1 + share * (b.1 - a.1)))
}

/// The range of costs that every seed of a method covers.
fn range(seeds: &[Curve], over: Over) -> Option<(f64, f64)> {
    let costs = |curve: &Curve| -> Option<(f64, f64)> {
        let logs = logs(curve, over, Error::RelativeRmse);
        Some((libm::exp(logs.first()?.0), libm::exp(logs.last()?.0)))
    };
    let all: Vec<(f64, f64)> = seeds.iter().filter_map(costs).collect();
    let range = all.iter().copied().reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))?;
    (range.0 < range.1).then_some(range)
}

/// Times at which methods are compared, in decreasing order: the longest time that two methods reach with every seed, a
/// quarter of it, and so on, as long as two methods have been measured there.
fn costs(methods: &[Vec<Curve>], over: Over) -> Vec<f64> {
    let ranges: Vec<(f64, f64)> = methods.iter().filter_map(|seeds| range(seeds, over)).collect();
    let mut ends: Vec<f64> = ranges.iter().map(|r| r.1).collect();
    ends.sort_by(f64::total_cmp);
    let Some(top) = ends.len().checked_sub(2).map(|i| ends[i]) else { return Vec::new() };
    // Slightly smaller, so that the last point remains inside after taking the logarithm and its inverse.
    let times = (0..MOST).map(|k| top * (1.0 - 1e-9) / STEP.powi(k as i32));
    let inside = |t: &f64| ranges.iter().filter(|r| r.0 <= *t && *t <= r.1).count() >= 2;
    times.filter(inside).collect()
}

/// The errors of each method after equal times. Efficiencies are relative to the first method.
pub fn equal_costs(methods: &[Vec<Curve>], over: Over) -> Vec<Vec<EqualCost>> {
    let costs = costs(methods, over);
    let of = |seeds: &Vec<Curve>, is_first: bool| {
        let at = |cost: &f64| one(seeds, methods.first().filter(|_| !is_first)?, over, *cost);
        let alone = |cost: &f64| one(seeds, &Vec::new(), over, *cost);
        costs.iter().filter_map(|cost| if is_first { alone(cost) } else { at(cost) }).collect()
    };
    methods.iter().enumerate().map(|(i, seeds)| of(seeds, i == 0)).collect()
}

fn one(seeds: &[Curve], first: &[Curve], over: Over, cost: f64) -> Option<EqualCost> {
    let at = |curves: &[Curve]| -> Option<Vec<f64>> {
        curves.iter().map(|curve| error_at(curve, over, cost)).collect()
    };
    let errors = at(seeds)?;
    let error = statistics::geometric_mean(&errors, statistics::CONFIDENCE)?;
    let ratios: Option<Vec<f64>> =
        at(first).map(|first| first.iter().zip(&errors).map(|(a, b)| (a / b) * (a / b)).collect());
    let efficiency = ratios.and_then(|ratios| statistics::geometric_mean(&ratios, statistics::CONFIDENCE));
    Some(EqualCost { cost, error, efficiency })
}

#[cfg(test)]
mod tests {
    use super::super::fall::tests::curves;
    use super::*;

    /// A method that is three times as slow at equal error has a third of the efficiency at equal time if the MSE falls
    /// as 1/N; with another slope the ratio depends on the time.
    #[test]
    fn errors_after_equal_times() {
        let slow = curves(5, -1.0, 1.0, 0.03, 0.0);
        let fast = curves(5, -1.0, 1.0, 0.01, 0.0);
        let steep = curves(5, -1.5, 1.0, 0.01, 0.0);
        let found = equal_costs(&[slow, fast, steep], Over::Seconds);
        // 256 samples of the fast method take 2.56 s.
        let times: Vec<f64> = found[1].iter().map(|e| e.cost).collect();
        assert!((times[0] - 2.56).abs() < 1e-6 && (times[1] - 0.64).abs() < 1e-6, "{times:?}");
        for (e, first) in found[1].iter().zip(&found[0]) {
            let ratio = e.efficiency.unwrap().value;
            assert!((ratio - 3.0).abs() < 1e-6 && first.efficiency.is_none(), "{ratio}");
            // The relative RMSE is half the root of the MSE, which is 1/samples.
            assert!((e.error.value - 0.5 * (0.01 / e.cost).sqrt()).abs() < 1e-9, "{e:?}");
        }
        // N^-1.5 at N = t/0.01 compared with 1/N at N = t/0.03.
        for e in &found[2] {
            let n = e.cost / 0.01;
            assert!((e.efficiency.unwrap().value / (3.0 * n.sqrt()) - 1.0).abs() < 1e-6, "{e:?}");
        }
        assert!(found[2].len() == found[1].len() && times.len() >= 3);
    }

    #[test]
    fn nothing_is_said_beyond_what_was_measured() {
        let one = curves(3, -1.0, 1.0, 0.01, 0.0);
        assert_eq!(equal_costs(std::slice::from_ref(&one), Over::Seconds), [vec![]]);
        assert_eq!(equal_costs(&[vec![], one.clone()], Over::Seconds), [vec![], vec![]]);
        // Ten thousand times as slow: there is no common time.
        let late = curves(3, -1.0, 1.0, 100.0, 0.0);
        assert_eq!(equal_costs(&[late, one.clone()], Over::Seconds), [vec![], vec![]]);
        // A single seed has an error but no interval.
        let single = curves(1, -1.0, 1.0, 0.02, 0.0);
        let found = equal_costs(&[one, single], Over::CpuSeconds);
        assert!(!found[1].is_empty() && found[1].iter().all(|e| !e.efficiency.unwrap().is_known()));
    }

    /// The intervals over seeds contain the true ratio.
    #[test]
    fn noisy_seeds() {
        let slow = curves(8, -1.0, 1.0, 0.02, 0.2);
        let fast: Vec<Curve> = curves(16, -1.0, 1.0, 0.01, 0.2).split_off(8);
        let found = equal_costs(&[slow, fast], Over::Seconds);
        assert!(found[1].iter().all(|e| e.efficiency.unwrap().is_known()));
        assert!(
            found[1].iter().filter(|e| e.efficiency.unwrap().contains(2.0)).count() >= found[1].len() - 1
        );
    }
}
