//! Output formats and their file name extensions.

use crate::ImageError;
use std::path::Path;

/// The format of an output, determined by its extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: layers, linear, metadata.
    Exr,
    /// PNG: 8 or 16 bits after a tone curve.
    Png,
    /// Radiance RGBE: linear, 8-bit mantissas with a common exponent.
    Hdr,
}

impl Format {
    /// Determines the format from the extension, ignoring case. Returns an error if there is no extension, if it is
    /// unknown, or if this build does not support the format.
    pub fn of(path: &Path) -> Result<Self, ImageError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "exr" if cfg!(feature = "exr") => Ok(Self::Exr),
            "exr" => Err(feature_off(path, "EXR", "exr")),
            "png" if cfg!(feature = "png") => Ok(Self::Png),
            "png" => Err(feature_off(path, "PNG", "png")),
            "hdr" => Ok(Self::Hdr),
            _ => Err(ImageError::UnknownExtension(path.to_path_buf())),
        }
    }
}

/// The error that names the required feature.
pub(super) fn feature_off(path: &Path, format: &'static str, feature: &'static str) -> ImageError {
    ImageError::NotBuiltIn { name: path.display().to_string(), format, feature }
}
