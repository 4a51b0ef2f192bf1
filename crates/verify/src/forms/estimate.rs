//! Measurements of an integrator with an estimator on a scene: value, standard error, and the rate at which the error
//! falls.

use super::form::Form;
use crate::scenes::run;
use crate::tally::{ERRORS, Outcome};
use dapple_integrator::sampling::{Moments, Pattern, SampleSet};
use dapple_integrator::{Effect, MethodKind, SampleSets, Settings};

/// The measurement of one integrator with one estimator.
#[derive(Clone, Debug)]
pub struct Measured {
    /// `path` or `distribution`.
    pub method: &'static str,
    /// The sampling pattern.
    pub pattern: Pattern,
    /// Expected value, mean, standard error and tolerance.
    pub outcome: Outcome,
    /// Exponent of the mean squared error against the number of points; `None` if no error remains.
    pub rate: Option<f64>,
}

/// Measures every integrator with every estimator on one scene, by `replicas` independent renders each.
pub fn measure(form: &Form, replicas: u64) -> Vec<Measured> {
    let mut all = Vec::new();
    for (method, name) in [(MethodKind::Path, "path"), (MethodKind::Distribution, "distribution")] {
        for pattern in [Pattern::Grid, Pattern::Random, Pattern::Stratified, Pattern::Sobol] {
            if pattern != Pattern::Grid || form.grid.is_some() {
                all.push(estimate(form, (method, name), pattern, replicas));
            }
        }
    }
    all
}

/// Settings with `side`² points for every enabled effect.
fn settings(form: &Form, method: MethodKind, pattern: Pattern, side: u32, seed: u64) -> Settings {
    let mut plans = SampleSets::default();
    for (effect, _) in Effect::ALL {
        let plan = SampleSet { nx: side, ny: side, pattern };
        *plans.of_mut(effect) = if form.effects.contains(&effect) { plan } else { SampleSet::OFF };
    }
    Settings { size: (1, 1), pattern, seed, plans, max_bounces: form.max_bounces, ..Settings::default() }
        .with_method(method)
        .with_threads(1)
        .with_spp(side * side)
        .with_path(|p| p.roulette = false)
}

fn values(form: &Form, method: MethodKind, pattern: Pattern, side: u32, replicas: u64) -> Moments {
    let value = |seed| {
        let p = run(&form.scene, &settings(form, method, pattern, side, seed)).film.mean_at(0, 0);
        p.element_sum() / 3.0
    };
    (0..replicas).map(value).collect()
}

/// Mean squared error: variance plus squared bias.
fn mse(m: &Moments, exact: f64) -> f64 {
    m.variance() + (m.mean - exact).powi(2)
}

fn estimate(
    form: &Form,
    (method, name): (MethodKind, &'static str),
    pattern: Pattern,
    replicas: u64,
) -> Measured {
    let is_grid = pattern == Pattern::Grid;
    let (few, many, replicas) = if is_grid { (8, 32, 2) } else { (4, 8, replicas) };
    let small = values(form, method, pattern, few, replicas);
    let large = values(form, method, pattern, many, replicas);
    let (a, b) = (mse(&small, form.exact), mse(&large, form.exact));
    // Below the rounding error there is no rate.
    let floor = (1e-6 * form.exact).powi(2);
    let rate =
        (a > floor && b > floor).then(|| (b / a).ln() / (f64::from(many) / f64::from(few)).powi(2).ln());
    let error = if is_grid { 0.0 } else { large.standard_error() };
    let rounding = 5e-6 * form.exact.abs();
    let tolerance = match form.grid {
        Some(bound) if is_grid => bound / f64::from(many) + rounding,
        _ => ERRORS * error + rounding,
    };
    let telling = is_grid || form.certain || error <= 0.02 * form.exact;
    let passed = (large.mean - form.exact).abs() <= tolerance && telling;
    let note = format!("{} points, {replicas} renders", many * many);
    let outcome = Outcome { expected: form.exact, measured: large.mean, error, tolerance, passed, note };
    Measured { method: name, pattern, outcome, rate }
}
