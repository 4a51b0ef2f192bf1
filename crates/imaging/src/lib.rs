//! Reading and writing of linear images, textures, and tone curves.
//!
//! Colours are linear Rec.709 [`glam::Vec3`]; pixels are stored row by row from the top left. This crate has no
//! knowledge of rays, scenes or samples.

#![forbid(unsafe_code)]

pub mod color;
pub mod error;
pub mod frame;
pub mod memory;
pub mod metering;
pub mod picture;
pub mod read;
#[cfg(feature = "text")]
pub mod sheet;
#[cfg(feature = "text")]
pub mod text;
pub mod texture;
pub mod tone;
pub mod window;
pub mod windowed;
pub mod write;

pub use dapple_math::{self as math, Image};
pub use error::ImageError;
pub use frame::Frame;
pub use memory::MemoryLimit;
pub use picture::{Layer, Layers, MetaValue};
pub use read::{Rgba8, Rgba16, Texels};
pub use texture::{Channels, Encoding, Interpolation, Sampler, Texture, Wrap};
pub use tone::{Tone, UnknownTone};
pub use window::Window;
pub use windowed::Windowed;

#[cfg(all(doctest, feature = "exr", feature = "png"))]
#[doc = include_str!("../README.md")]
struct Readme;
