//! Each effect alone and several at once against closed forms, with every estimator, in both tracers.
//!
//! Random, stratified and Sobol points: within 4 standard errors of the exact value. The grid: equal to its own
//! midpoint sum, or within the bound of the midpoint rule.

#[path = "../common/mod.rs"]
mod common;

mod caps;
mod defocus;
mod edges;
mod gloss;
mod irradiance;
mod penumbra;
mod refraction;
mod sphere;
