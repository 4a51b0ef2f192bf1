//! One integral, four estimators, many sample counts: the data of one table row.

use crate::fit::{Slope, slope};
use dapple_sampling::{Moments, Pattern, SampleSet};

pub const ESTIMATORS: [Pattern; 4] = [Pattern::Random, Pattern::Stratified, Pattern::Grid, Pattern::Sobol];

/// Layout of the sample counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layout {
    /// N×1: the integrand depends only on the first coordinate.
    Line,
    /// 1×N: the integrand depends only on the second coordinate.
    Column,
    /// √N×√N.
    Square,
}

/// An integral, evaluated with the complete tracer.
pub struct Study<'a> {
    pub name: &'a str,
    pub layout: Layout,
    /// Sample counts; powers of four.
    pub counts: &'a [u32],
    /// Slopes of random, stratified, grid and Sobol; `None` where theory predicts no power law.
    pub expected: [Option<f64>; 4],
    /// Error of replica `seed` with these points.
    pub error: &'a (dyn Fn(SampleSet, u64) -> f64 + 'a),
}

/// From 16 on: four octaves for the regular tests, eight for the table.
pub const FEW: [u32; 3] = [16, 64, 256];
pub const MANY: [u32; 5] = [16, 64, 256, 1024, 4096];
/// Smooth in one dimension, the error of the grid reaches the rounding of f32 above 256.
pub const FEW_ON_A_LINE: [u32; 3] = [4, 16, 64];
pub const MANY_ON_A_LINE: [u32; 4] = [4, 16, 64, 256];

/// Effort of a study.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    pub replicas: u64,
    pub long: bool,
    /// Allowed difference between a slope at finite N and that for N → ∞.
    pub finite: f64,
}

pub const QUICK: Effort = Effort { replicas: 200, long: false, finite: 0.15 };
pub const FULL: Effort = Effort { replicas: 400, long: true, finite: 0.1 };

impl Effort {
    pub fn counts(self) -> &'static [u32] {
        if self.long { &MANY } else { &FEW }
    }

    pub fn counts_on_a_line(self) -> &'static [u32] {
        if self.long { &MANY_ON_A_LINE } else { &FEW_ON_A_LINE }
    }
}

impl Study<'_> {
    fn plan(&self, n: u32, pattern: Pattern) -> SampleSet {
        match self.layout {
            Layout::Line => SampleSet { nx: n, ny: 1, pattern },
            Layout::Column => SampleSet { nx: 1, ny: n, pattern },
            Layout::Square => SampleSet::new(n, pattern),
        }
    }

    /// Every count has its own seeds: the points of the fit are independent.
    pub fn slope(&self, pattern: Pattern, replicas: u64) -> Slope {
        let squares = |n: u32| -> Moments {
            let first = u64::from(n) * 1_000_003;
            (0..replicas).map(|r| (self.error)(self.plan(n, pattern), first + r).powi(2)).collect()
        };
        slope(&self.counts.iter().map(|&n| (n, squares(n))).collect::<Vec<_>>())
    }

    /// Asserts that each slope is within 4 standard errors of the expected one, plus the allowance for finite N; prints
    /// a row with 95 % intervals.
    #[track_caller]
    pub fn check(&self, effort: Effort) {
        let slopes = ESTIMATORS.map(|pattern| self.slope(pattern, effort.replicas));
        let cells = slopes.map(|s| format!("{:.2} ± {:.2}", s.value, 1.96 * s.error));
        let range = format!("{}–{}", self.counts[0], self.counts[self.counts.len() - 1]);
        println!("| {} | {range} | {} |", self.name, cells.join(" | "));
        for ((pattern, slope), expected) in ESTIMATORS.iter().zip(slopes).zip(self.expected) {
            let Some(expected) = expected else { continue };
            let Slope { value, error } = slope;
            assert!(error < 0.12, "{}, {pattern}: ± {error} is inconclusive", self.name);
            assert!(
                (value - expected).abs() <= effort.finite + 4.0 * error,
                "{}, {pattern}: {value:.3} ± {error:.3}, expected {expected}",
                self.name
            );
        }
    }
}
