//! Linear pictures in and out: EXR, HDR and PNG, texture lookup, tone curves.
//!
//! A picture is linear Rec.709 radiance from the top left, row by row. Files are written beside their target under a
//! temporary name and renamed, so an existing file is never left half-written.
#![forbid(unsafe_code)]

pub mod color;
pub mod error;
pub mod picture;
pub mod read;
pub mod text;
pub mod texture;
pub mod tone;
pub mod write;

pub use error::ImageError;
pub use picture::{Layer, Layers, MetaValue, Picture};
pub use read::Rgba8;
pub use texture::{Encoding, Interpolation, Sampler, Texture, Wrap};
pub use tone::Tone;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
