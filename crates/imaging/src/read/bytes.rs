//! Decoding of images in memory to texels.

use super::decoders::{raster_rgba8, raster_size, raster_texels};
use super::kind::Kind;
use super::limits::Room;
use super::texels::{Rgba8, Texels};
use crate::{ImageError, MemoryLimit};
use std::io::Cursor;

/// Decodes a PNG, JPEG or WebP image to RGBA8; `name` is used in error messages. Grey becomes equal R, G, B; missing
/// alpha is opaque; 16 bits are rounded to 8. Values keep the encoding of the file.
pub fn rgba8(bytes: &[u8], name: &str) -> Result<Rgba8, ImageError> {
    rgba8_within(bytes, name, MemoryLimit::NONE)
}

/// As [`rgba8`], with a memory limit.
pub fn rgba8_within(bytes: &[u8], name: &str, limit: MemoryLimit) -> Result<Rgba8, ImageError> {
    let kind = texture_kind(bytes, name)?;
    raster_rgba8(Cursor::new(bytes), kind, name, Room::new(limit, bytes.len() as u64, kind))
}

/// Width and height of the result of [`rgba8`], from the header alone.
pub fn size(bytes: &[u8], name: &str) -> Result<[u64; 2], ImageError> {
    raster_size(Cursor::new(bytes), texture_kind(bytes, name)?, name)
}

/// As [`rgba8`], but a PNG of 16 bits keeps them, unless its values need no more than 8.
pub fn texels(bytes: &[u8], name: &str) -> Result<Texels, ImageError> {
    texels_within(bytes, name, MemoryLimit::NONE)
}

/// As [`texels`], with a memory limit.
pub fn texels_within(bytes: &[u8], name: &str, limit: MemoryLimit) -> Result<Texels, ImageError> {
    let kind = texture_kind(bytes, name)?;
    raster_texels(Cursor::new(bytes), kind, name, Room::new(limit, bytes.len() as u64, kind))
}

/// The format of a texture; an error if it is not PNG, JPEG or WebP.
fn texture_kind(bytes: &[u8], name: &str) -> Result<Kind, ImageError> {
    match Kind::by_content(bytes) {
        Some(kind @ (Kind::Png | Kind::Jpeg | Kind::WebP)) => Ok(kind),
        Some(kind) => Err(ImageError::Unsupported {
            name: name.to_string(),
            what: format!("{} as a texture (use PNG, JPEG or WebP)", kind.name()),
        }),
        None => Err(ImageError::NotAPicture { name: name.to_string() }),
    }
}
