//! Sample points in the unit square, warps with their densities, discrete distributions, MIS weights and moments.
//!
//! There is no generator with a state: every number is a pure function of a [`Key`] and an index, so that any sample of
//! any pixel can be reproduced alone.
#![forbid(unsafe_code)]

mod arrangement;
pub mod discrete;
pub mod grid2d;
pub mod key;
pub mod lanes;
pub mod mis;
pub mod pattern;
pub mod sample_set;
pub mod sobol;
pub mod stats;
mod table;
pub mod warp;

pub use discrete::{Choice, Discrete};
pub use grid2d::{Grid2d, GridSample};
pub use key::Key;
pub use pattern::{Pattern, padded_1d, padded_2d, point_1d, point_2d};
pub use sample_set::{SampleSet, SampleSetError};
pub use stats::Moments;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
