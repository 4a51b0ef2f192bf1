//! Cameras, lenses, pixel filters, shutter and film.
//!
//! [`Camera`] computes the ray of a film point and a lens point, [`Filter`] samples the film point, [`Shutter`] the
//! time, and [`Film`] accumulates the samples with their variance. The crate does not depend on the intersection of
//! rays.
#![forbid(unsafe_code)]
pub mod camera;
pub mod film;
pub mod filter;
pub mod lanes;
pub mod lens;
mod precise;
pub mod shutter;
pub mod sums;
mod view;
pub use camera::{Camera, Clip, Projection};
pub use dapple_math as math;
pub use film::{Film, FilmMismatch};
pub use filter::{Filter, FilterError};
pub use lens::{Aperture, ApertureError, Lens};
pub use shutter::Shutter;
pub use sums::{Overlap, PixelMoments, SampleSums, SumNode};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
