//! Aggregation of many checks into one outcome: the check that came closest to its tolerance or exceeded it most.

use dapple_integrator::sampling::Moments;
use serde::Serialize;

/// Number of standard errors by which an estimate may deviate.
pub(crate) const ERRORS: f64 = 4.0;

/// The outcome of a check.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The expected value.
    pub expected: f64,
    /// The measured value.
    pub measured: f64,
    /// Standard error of `measured`; 0 if nothing is random.
    pub error: f64,
    /// Maximum of |measured − expected|.
    pub tolerance: f64,
    /// Whether every check passed.
    pub passed: bool,
    /// The check that the numbers belong to, and the number of checks: the one closest to its tolerance or farthest
    /// beyond it.
    pub note: String,
}

/// Collects the checks of a case.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    worst: Option<(f64, Outcome)>,
    checks: usize,
    failed: usize,
    remarks: Vec<String>,
}

impl Tally {
    /// Checks that |measured − expected| ≤ tolerance.
    pub fn within(&mut self, what: impl Into<String>, measured: f64, expected: f64, tolerance: f64) {
        self.add(what.into(), measured, expected, tolerance, 0.0);
    }

    /// Checks that both values are equal.
    pub fn exactly(&mut self, what: impl Into<String>, measured: f64, expected: f64) {
        self.within(what, measured, expected, 0.0);
    }

    /// Checks that a count of failures is zero.
    pub fn none(&mut self, what: impl Into<String>, count: u64) {
        self.exactly(what, count as f64, 0.0);
    }

    /// Checks that `measured` ≤ `most`.
    pub fn at_most(&mut self, what: impl Into<String>, measured: f64, most: f64) {
        let expected = if measured > most { most } else { measured };
        self.add(what.into(), measured, expected, 0.0, 0.0);
    }

    /// Checks that a condition is true.
    pub fn holds(&mut self, what: impl Into<String>, truth: bool) {
        self.exactly(what, f64::from(truth), 1.0);
    }

    /// Checks that an estimate lies within 4 standard errors plus a millionth of the expected value, and that its
    /// standard error is at most `most` of the expected value (of 1 if that is 0), so that a check that is too noisy to
    /// fail fails.
    pub fn mean(&mut self, what: impl Into<String>, moments: &Moments, expected: f64, most: f64) {
        let error = moments.standard_error();
        let scale = if expected == 0.0 { 1.0 } else { expected.abs() };
        let what = what.into();
        self.at_most(format!("{what}: relative standard error"), error / scale, most);
        self.add(what, moments.mean, expected, ERRORS * error + 1e-6 * scale, error);
    }

    /// Adds a remark to the note.
    pub fn remark(&mut self, text: impl Into<String>) {
        self.remarks.push(text.into());
    }

    fn add(&mut self, what: String, measured: f64, expected: f64, tolerance: f64, error: f64) {
        let off = (measured - expected).abs();
        let ratio = match off {
            _ if off.is_nan() => f64::INFINITY,
            0.0 => 0.0,
            _ => off / tolerance,
        };
        let passed = ratio <= 1.0;
        self.checks += 1;
        self.failed += usize::from(!passed);
        if self.worst.as_ref().is_none_or(|(worst, _)| ratio > *worst) {
            let outcome = Outcome { expected, measured, error, tolerance, passed, note: what };
            self.worst = Some((ratio, outcome));
        }
    }

    /// The outcome of the worst check; without any check, a failure.
    pub fn finish(self) -> Outcome {
        let nothing = Outcome {
            expected: 1.0,
            measured: 0.0,
            error: 0.0,
            tolerance: 0.0,
            passed: false,
            note: "nothing was checked".into(),
        };
        let mut outcome = self.worst.map_or(nothing, |(_, outcome)| outcome);
        if self.checks > 1 {
            outcome.note = match self.failed {
                0 => format!("worst of {}: {}", self.checks, outcome.note),
                failed => format!("{failed} of {} fail; worst: {}", self.checks, outcome.note),
            };
        }
        for remark in self.remarks {
            outcome.note += &format!("; {remark}");
        }
        outcome
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_check_speaks_for_all() {
        let mut tally = Tally::default();
        tally.within("near", 1.01, 1.0, 0.1);
        tally.within("nearer to its limit", 2.09, 2.0, 0.1);
        tally.none("nothing", 0);
        let outcome = tally.finish();
        assert!(outcome.passed && outcome.note == "worst of 3: nearer to its limit");
        for bad in [1.2, f64::NAN, f64::INFINITY] {
            let mut tally = Tally::default();
            tally.within("fine", 1.0, 1.0, 0.0);
            tally.within("bad", bad, 1.0, 0.1);
            tally.at_most("fine", 0.5, 1.0);
            let outcome = tally.finish();
            assert!(!outcome.passed && outcome.note.contains("1 of 3 fail; worst: bad"), "{outcome:?}");
        }
        assert!(!Tally::default().finish().passed);
    }

    #[test]
    fn an_estimate_too_noisy_to_fail_fails() {
        let noisy: Moments = [0.0, 2.0].into_iter().collect();
        let mut tally = Tally::default();
        tally.mean("noisy", &noisy, 1.0, 0.01);
        assert!(!tally.finish().passed);
        let wrong: Moments = (0..1000).map(|i| 1.1 + 0.01 * f64::from(i % 2)).collect();
        let mut tally = Tally::default();
        tally.mean("wrong", &wrong, 1.0, 0.01);
        assert!(!tally.finish().passed);
    }
}
