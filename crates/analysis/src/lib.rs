//! How wrong is a picture, and how fast does a method get it right?
//!
//! [`metrics`] compares pictures in linear radiance, [`flip`] as an eye would, [`ssim`] by their structure, [`heat`] shows
//! where the errors are. [`curve`] says how fast an error falls with samples and seconds, and [`statistics`] how sure that
//! is. [`converge`] renders the same scene
//! by several methods; [`results`], [`plot`] and [`report`] say what came out.
//! Pictures are linear Rec.709, row by row from the top left, whoever made them.
#![forbid(unsafe_code)]

pub mod budget;
pub mod converge;
pub mod curve;
pub mod estimate;
pub mod flip;
pub mod heat;
pub mod metrics;
pub mod plot;
pub mod report;
pub mod results;
pub mod ssim;
pub mod statistics;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
