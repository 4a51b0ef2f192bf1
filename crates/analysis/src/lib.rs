//! How wrong is a picture, and how fast does a method get it right?
//!
//! [`metrics`] compares pictures in linear radiance, [`flip`] as an eye would, [`heat`] shows where the errors are.
//! Pictures are linear Rec.709, row by row from the top left, whoever made them.
#![forbid(unsafe_code)]

pub mod flip;
pub mod heat;
pub mod metrics;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
