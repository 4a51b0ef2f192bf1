//! How wrong is a picture, and how fast does a method get it right?
//!
//! [`metrics`] compares pictures in linear radiance, [`flip`] as an eye would, [`ssim`] by their structure, [`heat`] shows
//! where the errors are. [`curve`] says how fast an error falls with samples and seconds, and [`statistics`] how sure that
//! is. [`converge`] renders the same scene
//! by several methods; [`results`], [`plot`] and [`report`] say what came out.
//! [`stress`] is the catalogue of stiff and extreme cases, [`verify`] holds the tracers against [`closed_form`]s.
//! Pictures are linear Rec.709, row by row from the top left, whoever made them.
#![forbid(unsafe_code)]

pub mod budget;
mod clock;
pub mod closed_form;
pub mod converge;
pub mod curve;
pub mod estimate;
pub mod flip;
pub mod heat;
pub mod metrics;
mod noise;
pub mod plot;
pub mod report;
pub mod results;
mod scenes;
pub mod ssim;
pub mod statistics;
pub mod stress;
mod tally;
pub mod verify;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
