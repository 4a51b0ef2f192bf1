//! 8-bit PNG through the `image` crate (pure Rust deflate: the same bytes everywhere).

use crate::ImageError;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use std::path::Path;

/// The caller has checked that there are `width * height` pixels; whether the last one is whole is checked here.
pub(super) fn encode(path: &Path, width: usize, height: usize, data: &[u8]) -> Result<Vec<u8>, ImageError> {
    let wrong = |why: String| ImageError::Inconsistent { path: path.to_path_buf(), why };
    if data.len() != width * height * 3 {
        return Err(wrong("its last pixel lacks a channel".into()));
    }
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(data, width as u32, height as u32, ExtendedColorType::Rgb8)
        .map_err(|e| wrong(e.to_string()))?;
    Ok(bytes)
}
