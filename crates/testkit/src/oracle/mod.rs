//! The formulas of warps, surfaces, lights and intersections in f64, written from their sources and not from the
//! renderer's rearranged ones: what f32 is measured against.

pub mod bsdf;
pub mod deviation;
pub mod light;
pub mod shape;
pub mod warp;

pub use deviation::Deviation;
