//! Points in the unit square and their densities: patterns, warps, discrete choices, MIS weights and moments.
//!
//! Nothing here holds state that advances: every number is a pure function of a [`Key`] and an index, so any sample of
//! any pixel can be made again alone.
#![forbid(unsafe_code)]

pub mod discrete;
pub mod grid2d;
mod hash;
pub mod key;
pub mod mis;
pub mod pattern;
pub mod sample_set;
pub mod sobol;
pub mod stats;
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
