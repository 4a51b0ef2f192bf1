//! BSDFs of the glTF material model in the local shading frame.
//!
//! In the local frame z is the shading normal on the front side of the surface. Directions are unit vectors that point
//! away from the shading point, and colours are linear Rec.709. The crate has no knowledge of scenes, textures or
//! lights: a [`Material`] holds plain numbers at one point, and a [`Bsdf`] is that material for one outgoing direction
//! `wo`.
//!
//! `f` is the BSDF without the cosine, for radiance transported against the ray (from `wi` to `wo`). `pdf` is the
//! probability density per solid angle about `wi`. [`Bsdf::sample_f`], [`Bsdf::pdf`] and [`Bsdf::f`] agree for every
//! set of [`Lobes`].
//!
//! Every formula is written once over lanes, in [`lanes`], for renderers that scatter many directions at a time.
#![forbid(unsafe_code)]

pub mod albedo;
mod albedo_table;
pub mod bounds;
pub mod bsdf;
pub mod fresnel;
pub mod lanes;
pub mod lobe;
pub mod material;
pub mod microfacet;
pub mod sample;

pub use bounds::Varying;
pub use bsdf::Bsdf;
pub use lobe::{Lobe, Lobes};
pub use material::{Material, Mirror};
pub use sample::BsdfSample;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
