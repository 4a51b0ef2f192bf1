//! The catalogue of stiff and extreme cases: every case states the typical failure of naive renderers, its source, and
//! a check that runs on the user's machine.
//!
//! A case that requires a missing feature is pending, with the reason; it neither passes nor fails.

mod bounds;
mod bsdf;
mod camera;
mod case;
mod catalogue;
mod deep;
mod fresnel;
mod gloss;
mod hits;
mod leaving;
mod lights;
mod many;
mod media;
mod motion;
mod paths;
mod places;
mod samples;
mod scale;
mod shading;
mod sky;
mod spheres;
mod system;
mod transforms;
mod triangles;

pub use crate::tally::Outcome;
pub use case::{Case, Check, Effort};
pub use catalogue::{catalogue, select};
