//! A case of the catalogue and how it is run.

use crate::tally::Outcome;
use std::panic::catch_unwind;

/// The effort of the checks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// For tests: seconds for the whole catalogue.
    Quick,
    /// Under three minutes for the catalogue on two cores.
    #[default]
    Normal,
    /// Without a time limit.
    Thorough,
}

impl Effort {
    /// One of three values by effort.
    pub(crate) fn of<T>(self, quick: T, normal: T, thorough: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Normal => normal,
            Self::Thorough => thorough,
        }
    }
}

/// The check of a case.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// A check that runs.
    Run(fn(Effort) -> Outcome),
    /// A check that requires a missing feature, with the reason.
    Pending(&'static str),
}

/// An entry of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Id, A01 to D20.
    pub id: &'static str,
    /// Subject of the case.
    pub title: &'static str,
    /// Typical failure of naive renderers.
    pub naive: &'static str,
    /// Source of the remedy or of the exact value.
    pub source: &'static str,
    /// The check.
    pub check: Check,
}

impl Case {
    /// The family that the first letter of the id denotes.
    pub fn family(&self) -> &'static str {
        match self.id.as_bytes()[0] {
            b'A' => "geometry and scale",
            b'B' => "lights",
            b'C' => "BSDF",
            _ => "estimator and system",
        }
    }

    /// Whether the case takes much longer than most and should be started early.
    pub fn is_long(&self) -> bool {
        matches!(self.id, "D01" | "D03" | "A12" | "B13")
    }

    /// Whether the case compares times and should run alone on the machine.
    pub fn is_timed(&self) -> bool {
        matches!(self.id, "A15" | "B08" | "D11")
    }

    /// Runs the check; `None` if it is pending. A check that panics fails.
    pub fn run(&self, effort: Effort) -> Option<Outcome> {
        let Check::Run(check) = self.check else { return None };
        Some(catch_unwind(|| check(effort)).unwrap_or_else(|_| Outcome {
            expected: 1.0,
            measured: 0.0,
            error: 0.0,
            tolerance: 0.0,
            passed: false,
            note: "the check panicked".into(),
        }))
    }
}
