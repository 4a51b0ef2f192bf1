//! From a pixel to a ray, and back to a picture.
//!
//! [`Camera`] turns a film point and a lens point into a ray, [`Filter`] places the film point, [`Shutter`] the time,
//! and [`Film`] sums what came back, with its variance. Nothing here knows what a ray hits.
#![forbid(unsafe_code)]
pub mod camera;
pub mod film;
pub mod filter;
pub mod lens;
pub mod shutter;
pub use camera::{Camera, Clip, Projection};
pub use dapple_math as math;
pub use film::{Film, RectMismatch};
pub use filter::{Filter, FilterError};
pub use lens::{Aperture, ApertureError, Lens};
pub use shutter::Shutter;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
