//! Does a build of the renderer compute what it should, on the machine it runs on?
//!
//! - [`stress`] is the catalogue of stiff and extreme cases: each has the one thing that goes wrong in naive renderers, its
//!   source, and a check with a tolerance that can be derived.
//! - [`forms`] renders scenes of one pixel whose value can be written down, by both tracers with every estimator, and says
//!   how fast the error falls.
//! - [`closed_form`] holds the formulas: irradiances, radiances and coverages in f64, free of any renderer.
//!
//! A check gives an [`stress::Outcome`]: expected value, measured value, standard error and tolerance. Estimates may be off
//! by four standard errors, and a check that is so noisy that it could not fail fails. Nothing here depends on test
//! libraries or on files, so that users can run all checks on their own machine.
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
