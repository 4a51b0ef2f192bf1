//! The path tracer, the distribution ray tracer, and the render loop.
//!
//! This crate is thin: scattering at a point is in `materials`, light sources are in `lights`, ray intersection is in
//! `geometry`. The crate itself contains only the estimators that combine them. All parts are re-exported as modules,
//! so that one dependency is enough to build a scene in code and render it.
#![forbid(unsafe_code)]

pub use dapple_camera as camera;
pub use dapple_geometry as geometry;
pub use dapple_imaging as imaging;
pub use dapple_lights as lights;
pub use dapple_materials as materials;
pub use dapple_math as math;
pub use dapple_sampling as sampling;
pub use dapple_scene as scene;

pub mod allocation;
pub mod aov;
mod batch;
pub mod bias_report;
pub mod bits;
mod clear;
mod coverage;
mod cryptomatte;
mod culling;
mod custom;
pub mod dimension;
mod dimensions_used;
mod direct;
mod distribution;
pub mod effects;
mod emission;
mod facts;
pub mod first_hit;
mod first_hit_sums;
pub mod forecast;
mod interface;
mod job;
mod kernel;
mod medium;
mod normals;
mod observer;
mod path;
pub mod peak;
mod places;
pub mod plan;
pub mod render;
pub mod replay;
mod sample;
mod scatter;
pub mod settings;
mod shadow;
mod shared_place;
pub mod tail;
mod terminator;
mod tile;
mod trace_context;
pub mod variances;
mod vertex;
mod visibility;

pub use allocation::{PILOT, SampleAllocation};
pub use aov::Aov;
pub use bias_report::BiasReport;
pub use bits::BITS;
pub use culling::Backfaces;
pub use custom::{Integrator, Intersection, SampleContext};
pub use dimension::Dimension;
pub use effects::{Combine, Effect, SampleSets};
pub use forecast::{Forecast, forecast};
pub use peak::{Peak, peak};
pub use plan::{RenderPlan, plan};
pub use render::{
    Advance, BadSample, Covered, Look, Outcome, Part, PartError, PilotResult, Progress, RenderState,
    Renderer, Snapshot, Stats, Watcher, missing, render, render_pilot, render_pixels, render_pixels_until,
    render_watched, sum_pixels_until,
};
pub use replay::{PathVertex, replay};
pub use settings::{DistributionSettings, Limits, MethodKind, PathSettings, Settings, SettingsError};
pub use tail::Tail;
pub use variances::{Variances, variances};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
