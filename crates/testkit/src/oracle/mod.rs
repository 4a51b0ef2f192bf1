//! Reference formulas of warps, BSDFs, lights and intersections in f64, for comparison with implementations in f32.
//! They are written from their sources, not from the rearranged formulas of the renderer.

pub mod bsdf;
pub mod deviation;
pub mod light;
pub mod shape;
pub mod warp;

pub use deviation::Deviation;
