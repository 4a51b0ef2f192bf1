//! The formulas of this crate over lanes: one material and one direction per lane, with the same bits for every number
//! of lanes. [`crate::Bsdf`] and the functions of the other modules are the instance of one lane, R = `f32`.
//!
//! Surfaces come in [kinds](Kind), and a [`Bsdf`] holds surfaces of one kind with parameters of their own:
//!
//! - diffuse reflection alone: [`Lambert`];
//! - metals and dielectrics, coat over diffuse base: [`Layers::opaque`];
//! - all of these, and clear dielectrics: [`Layers::new`];
//! - mirrors: [`Mirrored`].
//!
//! Material parameters are read from [`Columns`] or from a [`Palette`]. Whether a lane has a lobe is a mask; what no lane has is skipped.

mod albedo;
mod choice;
mod diffuse;
mod fresnel;
mod kind;
mod lambert;
mod layers;
mod microfacet;
mod mirror;
mod mirrored;
mod parameters;
mod reflection;
mod scatter;
mod transmission;

pub use crate::lobe::{meets, sharpened};
pub use albedo::{AlbedoRow, DirectionalAlbedo};
pub use choice::{Pick, Shares};
pub use diffuse::Diffuse;
pub use fresnel::{
    Interface, Schlick, dielectric, dielectric_between, far_cosine, normal_reflectance, refract,
    schlick_weight,
};
pub use kind::{Bsdf, Kind, Sample, face, is_seen};
pub use lambert::Lambert;
pub use layers::Layers;
pub use microfacet::{Ggx, SMOOTH_ALPHA, reflect};
pub use mirror::{SHARP_BLUR, SquareBlur, WIDEST_BLUR};
pub use mirrored::Mirrored;
pub use parameters::{Columns, Palette, Parameters};
pub use reflection::{Reflection, Rough};
pub use transmission::{ClearLayer, FacetCosines, Transmission, eval_refraction};
