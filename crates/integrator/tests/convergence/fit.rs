//! The slope of log MSE over log N, and its standard error.

use dapple_sampling::Moments;

/// A slope and its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Slope {
    pub value: f64,
    pub error: f64,
}

/// Weighted least squares of ln MSE over ln N. Each MSE is the mean of squared errors, and its logarithm has the
/// standard error of the mean over the mean.
pub fn slope(squared_errors: &[(u32, Moments)]) -> Slope {
    let points: Vec<[f64; 3]> = squared_errors
        .iter()
        .map(|(n, m)| {
            let relative = m.standard_error() / m.mean;
            assert!(relative > 0.0, "N = {n}: an MSE of {} without spread", m.mean);
            [f64::from(*n).ln(), m.mean.ln(), relative.powi(-2)]
        })
        .collect();
    let sum = |f: &dyn Fn(&[f64; 3]) -> f64| points.iter().map(f).sum::<f64>();
    let weight = sum(&|p| p[2]);
    let (x, y) = (sum(&|p| p[2] * p[0]) / weight, sum(&|p| p[2] * p[1]) / weight);
    let sxx = sum(&|p| p[2] * (p[0] - x).powi(2));
    let sxy = sum(&|p| p[2] * (p[0] - x) * (p[1] - y));
    Slope { value: sxy / sxx, error: sxx.sqrt().recip() }
}

#[test]
fn a_power_law_is_found() {
    let mut rng = dapple_testkit::Rng::new(5);
    let points: Vec<(u32, Moments)> = [16u32, 64, 256, 1024]
        .map(|n| (n, (0..400).map(|_| (rng.normal() * f64::from(n).powf(-0.75)).powi(2)).collect()))
        .into();
    let Slope { value, error } = slope(&points);
    assert!((value + 1.5).abs() < 4.0 * error && error < 0.05, "{value} ± {error}");
}
