//! Linear pictures in and out.
pub mod color;
pub mod error;
pub mod picture;
pub mod read;
pub mod texture;
pub mod tone;
pub mod write;
pub use error::ImageError;
pub use picture::{Layer, Layers, Picture};
pub use texture::{Interpolation, Sampler, Texture, Wrap};
pub use tone::Tone;
