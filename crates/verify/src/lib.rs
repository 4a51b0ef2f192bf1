//! Checks of a build of the renderer on the machine it runs on.
//!
//! - [`stress`] is the catalogue of stiff and extreme cases. Each case states the typical failure of naive renderers,
//!   its source, and a check with a derivable tolerance.
//! - [`forms`] renders scenes of one pixel with a known value, by both integrators with every estimator, and measures
//!   the rate at which the error falls.
//! - [`closed_form`] contains the formulas: irradiances, radiances and coverages in f64, independent of any renderer.
//!
//! A check returns an [`stress::Outcome`]: expected value, measured value, standard error and tolerance. Estimates may
//! deviate by four standard errors, and a check that is too noisy to fail fails. Nothing here depends on test libraries
//! or on files, so that users can run all checks on their own machine.
#![forbid(unsafe_code)]

mod clock;
pub mod closed_form;
pub mod forms;
mod noise;
mod scenes;
pub mod stress;
mod tally;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
