//! Where light comes from, and how to aim at it.
//!
//! [`Light::sample`] aims from a receiver at one light, [`Light::pdf`] is its density, [`LightSampler`] says which light to
//! aim at. All densities are per solid angle at the receiver. Units: radiance W·m⁻²·sr⁻¹, intensity W·sr⁻¹, irradiance
//! W·m⁻², per channel of linear Rec.709; lengths in render units. Nothing here knows what stands in the way.
#![forbid(unsafe_code)]
mod aimed;
pub mod aiming;
pub mod area;
mod cluster;
mod disk;
pub mod distant;
pub mod environment;
mod lanes;
pub mod light;
pub mod light_sampler;
pub mod moving;
mod oval;
mod part;
mod patch;
pub mod pattern;
mod placed;
pub mod point;
mod polygon;
mod rectangle;
pub mod sample;
pub mod solid_angle;
mod sphere;
mod split;
mod tree;
pub use aiming::{Aiming, Reached};
pub use area::{Area, AreaShape};
pub use dapple_math as math;
pub use distant::Distant;
pub use environment::{BadTexel, Environment};
pub use light::Light;
pub use light_sampler::LightSampler;
pub use moving::Moving;
pub use pattern::{Pattern, Patterned};
pub use point::{Point, Spot};
pub use sample::{LightPoint, LightSample};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
