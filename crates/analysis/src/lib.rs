//! Error metrics, error estimates and convergence studies of rendered images.
//!
//! [`metrics`] compares images in linear radiance, [`flip`] by perceived difference and [`ssim`] by structure; [`heat`]
//! maps errors to false colours. [`curve`] measures how fast an error falls with samples and time, and [`statistics`]
//! provides the confidence intervals. [`converge`] renders one scene with several methods; [`results`], [`plot`] and
//! [`report`] write the outcome. [`estimate`] estimates the error of a render without a reference, and [`budget`]
//! predicts the cost of an image of given error. Images are linear Rec.709, row by row from the top left, whichever
//! renderer made them.
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
