//! How light leaves a point, in the local frame (z = shading normal); knows no scene.
pub mod albedo;
pub mod bsdf;
pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod fresnel;
pub mod lobe;
pub mod material;
pub mod microfacet;
pub mod mirror;
pub use bsdf::{Bsdf, BsdfSample};
pub use lobe::{Lobe, Lobes};
pub use material::{Material, Mirror};
