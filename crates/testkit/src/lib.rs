//! Statistical tests, quadrature and brute-force references for tests. The crate depends on no other crate of the
//! workspace: everything is passed as closures and plain numbers, so that no test checks a renderer with that
//! renderer's own arithmetic.
//!
//! Everything is computed in f64 with a generator of its own and fixed seeds, so that results are reproducible.
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
