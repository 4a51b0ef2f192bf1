//! Statistics and brute force for tests. Knows none of the other crates: everything comes in as closures and plain
//! numbers, so that a test never checks a renderer with the renderer's own arithmetic.
//!
//! Everything is in f64, uses its own generator and fixed seeds: a pass stays a pass.
#![forbid(unsafe_code)]

pub mod chi_square;
pub mod closed_form;
pub mod intersect;
pub mod oracle;
mod partition;
pub mod quadrature;
pub mod rng;
pub mod z_test;

pub use rng::Rng;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
