//! In place of the error watch where the feature `report` is left out: renders do not know their own error.

use crate::error::Failure;
use crate::known::Known;
use crate::options::RenderOptions;
use crate::progress::Bar;
use dapple_integrator::camera::Camera;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Outcome, Settings, Snapshot};
use std::ops::ControlFlow;

/// Looks at nothing.
pub struct ErrorWatch;

impl ErrorWatch {
    /// Nothing is measured.
    pub fn share_of_time(_: &Settings) -> f64 {
        0.0
    }

    /// Fails if errors are asked for.
    pub fn new(_: (&Scene, &Camera, &Settings), options: &RenderOptions, _: &Bar) -> Result<Self, Failure> {
        let asked = [("--error-limit", options.error_limit.is_some()), ("--log", options.log.is_some())];
        match asked.iter().find(|(_, asked)| *asked) {
            None => Ok(Self),
            Some((option, _)) => Err(Failure::Arguments(format!(
                "{option}: this dapple was built without knowledge of errors (feature report)"
            ))),
        }
    }

    /// On and on.
    pub fn look(&mut self, _: &Snapshot<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Not known, and found out in no time.
    pub fn finish(self, _: &Outcome) -> Known {
        Known {
            why: "this dapple was built without knowledge of errors (feature report)".into(),
            ..Known::default()
        }
    }
}
