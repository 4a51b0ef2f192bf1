//! Light sources and light sampling.
//!
//! [`Light::sample`] samples a direction from a receiver towards one light, [`Light::pdf`] is the probability density
//! of that direction, and [`LightSampler`] selects the light to sample. All densities are per solid angle at the
//! receiver. Units: radiance W·m⁻²·sr⁻¹, intensity W·sr⁻¹, irradiance W·m⁻², per channel of linear Rec.709; lengths in
//! render units. Visibility is not known to this crate.
#![forbid(unsafe_code)]
mod aimed;
pub mod aiming;
pub mod area;
mod cluster;
mod descent;
mod disk;
pub mod distant;
pub mod environment;
mod falloff;
pub mod lanes;
mod lat_long;
pub mod light;
pub mod light_sampler;
pub mod moving;
mod octet;
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
