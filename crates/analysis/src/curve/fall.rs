//! Points of convergence curves, and the power law of the error over samples or time.

use crate::statistics::{self, Interval};

/// Error and cost measured at one sample count.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Point {
    /// Samples per pixel.
    pub samples: f64,
    /// Wall time of rendering in seconds; 0 if it was too short to be measured.
    pub seconds: f64,
    /// Processor time of all threads in seconds; 0 if it was too short to be measured.
    pub cpu_seconds: f64,
    /// Mean squared error.
    pub mse: f64,
    /// Mean squared error relative to R² + ε ([`crate::metrics`]).
    pub relmse: f64,
    /// RMSE divided by the mean of the reference.
    pub relative_rmse: f64,
}

/// The curve of one seed: points with increasing sample counts.
pub type Curve = Vec<Point>;

/// The error measure of a curve. Each falls as a power of the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// Mean squared error.
    Mse,
    /// Mean squared error relative to R² + ε.
    Relmse,
    /// Relative RMSE; its exponent is half that of the other measures.
    RelativeRmse,
}

/// The cost over which the error is plotted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// Samples per pixel.
    Samples,
    /// Wall time in seconds.
    Seconds,
    /// Processor time in seconds.
    CpuSeconds,
}

impl Point {
    /// The error by the given measure.
    pub fn error(&self, which: Error) -> f64 {
        match which {
            Error::Mse => self.mse,
            Error::Relmse => self.relmse,
            Error::RelativeRmse => self.relative_rmse,
        }
    }

    /// The cost in the given unit.
    pub fn cost(&self, over: Over) -> f64 {
        match over {
            Over::Samples => self.samples,
            Over::Seconds => self.seconds,
            Over::CpuSeconds => self.cpu_seconds,
        }
    }
}

/// Logarithms of cost and error of the points where both are positive and the error is finite.
pub(super) fn logs(curve: &[Point], over: Over, error: Error) -> Vec<(f64, f64)> {
    let usable = |p: &&Point| p.cost(over) > 0.0 && p.error(error) > 0.0 && p.error(error).is_finite();
    curve.iter().filter(usable).map(|p| (libm::log(p.cost(over)), libm::log(p.error(error)))).collect()
}

/// Exponent s and factor c of y = c·x^s, fitted to (log x, log y) by least squares; `None` with fewer than two
/// different x.
pub fn power_law(logs: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = logs.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let (spread, common) = (mean(&|p| (p.0 - x) * (p.0 - x)), mean(&|p| (p.0 - x) * (p.1 - y)));
    (logs.len() >= 2 && spread > 0.0).then(|| {
        let slope = common / spread;
        (slope, libm::exp(y - slope * x))
    })
}

/// The exponent by which the error falls, fitted per seed, with its confidence interval over seeds.
pub fn slope(seeds: &[Curve], over: Over, error: Error) -> Option<Interval> {
    let one = |curve: &Curve| power_law(&logs(curve, over, error)).map(|(slope, _)| slope);
    let slopes: Vec<f64> = seeds.iter().filter_map(one).collect();
    statistics::mean(&slopes, statistics::CONFIDENCE)
}

/// Efficiency 1/(relMSE · seconds) at the last point of each seed. It is constant along a curve whose error falls as
/// 1/seconds.
pub fn efficiency(seeds: &[Curve]) -> Option<Interval> {
    let last = seeds.iter().filter_map(|curve| curve.last());
    let all: Vec<f64> = last.map(|p| 1.0 / (p.relmse * p.seconds)).collect();
    statistics::geometric_mean(&all, statistics::CONFIDENCE)
}

/// The cost from which the error stays at or below `target`, interpolated linearly in logarithms between measured
/// points, never extrapolated. `None` if the curve does not reach `target`, or is below it from its first point.
pub fn cost_to(curve: &[Point], over: Over, error: Error, target: f64) -> Option<f64> {
    let logs = logs(curve, over, error);
    let wanted = libm::log(target);
    let above = logs.iter().rposition(|p| p.1 > wanted)?;
    let (a, b) = (logs[above], *logs.get(above + 1)?);
    Some(libm::exp(a.0 + (b.0 - a.0) * (a.1 - wanted) / (a.1 - b.1)))
}

/// The time of [`cost_to`] in seconds, averaged over seeds, with its interval; `None` unless every seed reaches the
/// error.
pub fn seconds_to(seeds: &[Curve], error: Error, target: f64) -> Option<Interval> {
    let all: Option<Vec<f64>> = seeds.iter().map(|c| cost_to(c, Over::Seconds, error, target)).collect();
    statistics::geometric_mean(&all?, statistics::CONFIDENCE)
}

/// Ratio of costs of two methods at equal error.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SpeedUp {
    /// Cost of `first` divided by the cost of the other method.
    pub ratio: Interval,
    /// The relative RMSE at which both are compared.
    pub at_error: f64,
}

/// The speed-up of `seeds` over `first` at the smallest error that both reach with every seed. Seeds are paired in
/// order.
pub fn speed_up(first: &[Curve], seeds: &[Curve], over: Over) -> Option<SpeedUp> {
    let error = Error::RelativeRmse;
    let last = |curve: &Curve| curve.last().map(|p| p.error(error));
    let reached = |all: &[Curve]| all.iter().filter_map(last).reduce(f64::max);
    // Slightly larger, so that the seed that defines the target reaches it as well.
    let target = f64::max(reached(first)?, reached(seeds)?) * (1.0 + 1e-9);
    let cost = |curve: &Curve| cost_to(curve, over, error, target);
    let ratios: Vec<f64> = first.iter().zip(seeds).filter_map(|(a, b)| Some(cost(a)? / cost(b)?)).collect();
    let ratio = statistics::geometric_mean(&ratios, statistics::CONFIDENCE)?;
    Some(SpeedUp { ratio, at_error: target })
}

/// Cost and error over seeds at each sample count that at least two seeds (or the only seed) have: the mean cost, 0
/// where that of a seed was too small to be measured, and the geometric mean of the error with its interval.
pub fn band(seeds: &[Curve], over: Over, error: Error) -> Vec<(f64, Interval)> {
    let mut counts: Vec<f64> = seeds.iter().flatten().map(|p| p.samples).collect();
    counts.sort_by(f64::total_cmp);
    counts.dedup();
    let enough = seeds.len().min(2);
    let at = |n: f64| {
        let points: Vec<&Point> = seeds.iter().filter_map(|c| c.iter().find(|p| p.samples == n)).collect();
        let costs: Vec<f64> = points.iter().map(|p| p.cost(over)).collect();
        let errors: Vec<f64> = points.iter().map(|p| p.error(error)).collect();
        let measured = costs.iter().all(|c| *c > 0.0);
        let cost = if measured { statistics::mean(&costs, statistics::CONFIDENCE)?.value } else { 0.0 };
        let error = statistics::geometric_mean(&errors, statistics::CONFIDENCE)?;
        (points.len() >= enough).then_some((cost, error))
    };
    counts.into_iter().filter_map(at).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use dapple_testkit::Rng;

    /// MSE = c N^s times a lognormal factor; one sample takes `second` seconds.
    pub(in super::super) fn curves(seeds: u64, s: f64, c: f64, second: f64, noise: f64) -> Vec<Curve> {
        (0..seeds).map(|seed| curve(seed, s, c, second, noise)).collect()
    }

    fn curve(seed: u64, s: f64, c: f64, second: f64, noise: f64) -> Curve {
        let mut rng = Rng::new(seed);
        let point = |k: i32, rng: &mut Rng| {
            let samples = f64::from(1 << k);
            let mse = c * samples.powf(s) * (noise * rng.normal()).exp();
            let seconds = samples * second;
            let relative_rmse = mse.sqrt() / 2.0;
            Point { samples, seconds, cpu_seconds: 2.0 * seconds, mse, relmse: mse / 4.0, relative_rmse }
        };
        (0..9).map(|k| point(k, &mut rng)).collect()
    }

    #[test]
    fn exact_power_laws_are_found() {
        for s in [-1.0, -1.5, -2.0, -0.25] {
            let seeds = curves(5, s, 3.0, 0.01, 0.0);
            let found = slope(&seeds, Over::Samples, Error::Mse).unwrap();
            assert!((found.value - s).abs() < 1e-12 && found.high - found.low < 1e-9);
            assert!((slope(&seeds, Over::Seconds, Error::Relmse).unwrap().value - s).abs() < 1e-12);
            assert!(
                (slope(&seeds, Over::Samples, Error::RelativeRmse).unwrap().value - s / 2.0).abs() < 1e-12
            );
        }
        assert_eq!(slope(&[], Over::Samples, Error::Mse), None);
        assert_eq!(power_law(&[(0.0, 1.0)]), None);
    }

    /// The interval over six noisy seeds contains the slope in 95 % of 1000 experiments.
    #[test]
    fn the_slope_lies_in_its_interval() {
        let held = (0..1000u64).filter(|i| {
            let seeds: Vec<Curve> = (0..6).map(|k| curve(6 * i + k, -1.5, 1.0, 0.01, 0.3)).collect();
            slope(&seeds, Over::Samples, Error::Mse).unwrap().contains(-1.5)
        });
        let share = held.count() as f64 / 1000.0;
        assert!((share - 0.95).abs() < 4.0 * (0.95 * 0.05 / 1000f64).sqrt(), "{share}");
    }

    #[test]
    fn seconds_to_an_error() {
        // Relative RMSE = ½ √(1/N) is 0.1 at N = 25, between 16 and 32; a sample takes 0.01 s.
        let seeds = curves(3, -1.0, 1.0, 0.01, 0.0);
        let found = seconds_to(&seeds, Error::RelativeRmse, 0.1).unwrap();
        assert!((found.value - 0.25).abs() < 1e-12, "{found:?}");
        assert_eq!(seconds_to(&seeds, Error::RelativeRmse, 1e-3), None);
        assert_eq!(seconds_to(&seeds, Error::RelativeRmse, 0.9), None);
        // A curve that rises again counts from where it stays below the target.
        let mut bumpy = seeds[0].clone();
        bumpy[6].relative_rmse = 0.2;
        assert!(cost_to(&bumpy, Over::Samples, Error::RelativeRmse, 0.1).unwrap() > 64.0);
    }

    #[test]
    fn speed_up_and_efficiency() {
        let slow = curves(5, -1.0, 1.0, 0.03, 0.0);
        let fast = curves(5, -1.0, 1.0, 0.01, 0.0);
        let found = speed_up(&slow, &fast, Over::Seconds).unwrap();
        assert!((found.ratio.value - 3.0).abs() < 1e-6, "{found:?}");
        assert!((speed_up(&fast, &fast, Over::Seconds).unwrap().ratio.value - 1.0).abs() < 1e-12);
        // relMSE · seconds = ¼ N⁻¹ · 0.01 N.
        let found = efficiency(&fast).unwrap();
        assert!((found.value - 400.0).abs() < 1e-9 && found.high - found.low < 1e-6, "{found:?}");
        let noisy = (curves(8, -1.0, 1.0, 0.03, 0.1), curves(8, -1.0, 1.0, 0.01, 0.2));
        let found = speed_up(&noisy.0, &noisy.1, Over::CpuSeconds).unwrap().ratio;
        assert!(found.contains(3.0) && found.high / found.low < 2.5, "{found:?}");
    }

    #[test]
    fn bands_are_over_seeds() {
        let seeds = curves(5, -1.0, 1.0, 0.01, 0.0);
        let found = band(&seeds, Over::Seconds, Error::Mse);
        assert_eq!(found.len(), 9);
        assert!((found[3].0 - 0.08).abs() < 1e-12 && (found[3].1.value - 0.125).abs() < 1e-12);
        let mut uneven = seeds;
        let more = Point { samples: 512.0, ..uneven[0][8] };
        uneven[0].push(more);
        assert_eq!(band(&uneven, Over::Samples, Error::Mse).len(), 9);
        uneven[1][3].seconds = 0.0;
        assert_eq!(band(&uneven, Over::Seconds, Error::Mse)[3].0, 0.0);
    }
}
