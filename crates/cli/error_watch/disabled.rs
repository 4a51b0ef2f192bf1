//! Replacement of the error watch without the feature `report`: renders do not estimate their error.

use crate::error::Failure;
use crate::known::Known;
use crate::options::RenderOptions;
use crate::progress::Bar;
use dapple_integrator::camera::Camera;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Outcome, Settings, Snapshot};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::time::Duration;

/// What a checkpoint holds of the error watch: nothing.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Saved;

/// An error watch that measures nothing.
pub struct ErrorWatch<'a>(std::marker::PhantomData<&'a ()>);

impl ErrorWatch<'_> {
    /// Returns the fraction of time to reserve for measurements: none.
    pub fn share_of_time(_: &Settings) -> f64 {
        0.0
    }

    /// Fails if an option needs error estimates.
    pub fn new(_: (&Scene, &Camera, &Settings), options: &RenderOptions, _: &Bar) -> Result<Self, Failure> {
        let asked = [("--error-limit", options.error_limit.is_some()), ("--log", options.log.is_some())];
        match asked.iter().find(|(_, asked)| *asked) {
            None => Ok(Self(std::marker::PhantomData)),
            Some((option, _)) => Err(Failure::Arguments(format!(
                "{option}: this dapple was built without error estimation (feature report)"
            ))),
        }
    }

    /// Returns what a resumed render needs.
    pub fn saved(&self) -> Saved {
        Saved
    }

    /// Continues where the watch of an interrupted render was; no check is due.
    pub fn resume(&mut self, _: Saved, _: Duration) -> Option<bool> {
        None
    }

    /// Whether the render needs no further samples.
    pub fn is_done(&self) -> bool {
        false
    }

    /// Never stops the render.
    pub fn look(&mut self, _: &Snapshot<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Returns no additional snapshot.
    pub fn next(&self) -> Option<u32> {
        None
    }

    /// Returns an unknown error.
    pub fn finish(self, _: &Outcome) -> Known {
        Known {
            why: "this dapple was built without error estimation (feature report)".into(),
            ..Known::default()
        }
    }
}
