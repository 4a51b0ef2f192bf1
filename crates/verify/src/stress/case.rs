//! One case of the catalogue: what it is about, and how it is run.

use crate::tally::Outcome;
use std::panic::catch_unwind;

/// How long checks may take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// For tests: seconds in all.
    Quick,
    /// Under three minutes on two cores.
    #[default]
    Normal,
    /// As long as it needs.
    Thorough,
}

impl Effort {
    /// One of three numbers.
    pub(crate) fn of<T>(self, quick: T, normal: T, thorough: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Normal => normal,
            Self::Thorough => thorough,
        }
    }
}

/// What a case does.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// Runs.
    Run(fn(Effort) -> Outcome),
    /// Waits for a feature; the reason.
    Pending(&'static str),
}

/// One entry of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// A01 to D20.
    pub id: &'static str,
    /// What it is about.
    pub title: &'static str,
    /// What goes wrong in naive renderers.
    pub naive: &'static str,
    /// Where the fix or the exact value comes from.
    pub source: &'static str,
    /// What is done.
    pub check: Check,
}

impl Case {
    /// What the first letter of the id means.
    pub fn family(&self) -> &'static str {
        match self.id.as_bytes()[0] {
            b'A' => "geometry and scale",
            b'B' => "lights",
            b'C' => "BSDF",
            _ => "estimator and system",
        }
    }

    /// Whether it takes much longer than most: better begun early.
    pub fn is_long(&self) -> bool {
        matches!(self.id, "D01" | "D03" | "A12" | "B13")
    }

    /// Whether it compares times, and so wants the machine to itself.
    pub fn is_timed(&self) -> bool {
        matches!(self.id, "A15" | "B08" | "D11")
    }

    /// Runs the check; None when it is pending. A check that panics fails.
    pub fn run(&self, effort: Effort) -> Option<Outcome> {
        let Check::Run(check) = self.check else { return None };
        Some(catch_unwind(|| check(effort)).unwrap_or_else(|_| Outcome {
            expected: 1.0,
            measured: 0.0,
            error: 0.0,
            tolerance: 0.0,
            passed: false,
            note: "the check itself broke off".into(),
        }))
    }
}
