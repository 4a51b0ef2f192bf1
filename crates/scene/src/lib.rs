//! Validated scenes: geometry, materials, lights and cameras, read from glTF or built in code.
//!
//! A [`SceneBuilder`] takes objects in world space (f64, the file's units, metres in glTF); [`SceneBuilder::build`]
//! validates them, transforms them to render space ([`space`]) and returns a [`Scene`], which is everything a ray
//! tracer reads. This crate draws no random numbers and has no knowledge of light transport.
#![forbid(unsafe_code)]
mod attributes;
mod bake;
pub mod bodies;
pub mod builder;
pub mod builtin;
mod channels;
pub mod coincident;
mod constants;
mod emission;
mod emitter;
pub mod error;
mod exposure;
mod extremes;
mod form;
mod framing;
#[cfg(feature = "gltf")]
pub mod gltf;
pub mod light_unit;
mod lobes;
mod lookup;
mod mapped_frame;
pub mod material;
pub mod memory;
mod moving;
mod object;
mod patterns;
mod pieces;
mod punctual;
pub mod reads;
pub mod scene;
mod slots;
pub mod space;
pub mod studio;
pub mod survey;
mod tangent;
mod texels;
pub mod view;
mod warnings;
pub use bodies::{Bodies, Body};
pub use builder::{CameraPose, SceneBuilder};
pub use coincident::SharedPlaces;
pub use error::{SceneError, Warning};
pub use light_unit::LightUnit;
pub use mapped_frame::MappedNormal;
pub use material::{AlphaMode, TextureUse, TexturedMaterial};
pub use object::Object;
pub use reads::Reads;
pub use scene::{NamedCamera, Scene, Shading};
pub use space::{Placement, Space, WorldPoint};
pub use survey::{Survey, Unread};
pub use texels::Texels;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
