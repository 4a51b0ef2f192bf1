//! Writing of images and layers, with one function per format.

use super::file::{probe, replace};
use super::format::Format;
#[cfg(not(all(feature = "exr", feature = "png")))]
use super::format::feature_off;
#[cfg(feature = "png")]
use super::options::PngDepth;
use super::options::{Depth, PngOptions};
use crate::{Image, ImageError, Layers, Tone};
use std::path::Path;

/// Writes all layers as one part of an EXR: ZIP in blocks of 16 rows, no alpha unless a layer has one, channels named
/// `layer.channel`, Rec.709 chromaticities, and the metadata as attributes. A crop keeps its data window within the
/// display window. Compression uses as many threads as the rayon pool from which it is called.
#[cfg(feature = "exr")]
pub fn exr(path: &Path, layers: &Layers, depth: Depth) -> Result<(), ImageError> {
    replace(path, &super::exr::encode(path, layers, depth)?)
}

/// Writes all layers as one part of an EXR; always fails, because this build does not support the format.
#[cfg(not(feature = "exr"))]
pub fn exr(path: &Path, _layers: &Layers, _depth: Depth) -> Result<(), ImageError> {
    Err(feature_off(path, "EXR", "exr"))
}

/// Writes an 8-bit PNG of [`code_values`]: exposure in stops, tone curve, rounding to nearest.
pub fn png(path: &Path, picture: &Image, tone: Tone, exposure: f32) -> Result<(), ImageError> {
    png_with(path, picture, &PngOptions { tone, exposure, ..PngOptions::default() })
}

/// As [`png`], with all options of the format. The file declares its values as sRGB.
#[cfg(feature = "png")]
pub fn png_with(path: &Path, picture: &Image, options: &PngOptions<'_>) -> Result<(), ImageError> {
    check_size(path, picture)?;
    let unlike = options.alpha.filter(|alpha| alpha.len() != picture.pixels.len());
    if let Some(alpha) = unlike {
        let why = format!(
            "an image of {} pixels cannot have a coverage of {} values",
            picture.pixels.len(),
            alpha.len()
        );
        return Err(ImageError::Inconsistent { path: path.to_path_buf(), why });
    }
    let encoded = match options.depth {
        PngDepth::Eight => super::png::code_values(picture, options, |v| [(v * 255.0 + 0.5) as u8]),
        PngDepth::Sixteen => {
            super::png::code_values(picture, options, |v| ((v * 65_535.0 + 0.5) as u16).to_ne_bytes())
        }
    };
    let kind = (options.alpha.is_some(), options.depth);
    replace(path, &super::png::encode(path, (picture.width, picture.height), &encoded, kind, options.texts)?)
}

/// Writes a PNG; always fails, because this build does not support the format.
#[cfg(not(feature = "png"))]
pub fn png_with(path: &Path, _picture: &Image, _options: &PngOptions<'_>) -> Result<(), ImageError> {
    Err(feature_off(path, "PNG", "png"))
}

/// Writes sRGB code values (red, green, blue, row by row from the top left) as an 8-bit PNG.
#[cfg(feature = "png")]
pub fn rgb8(path: &Path, width: usize, height: usize, data: Vec<u8>) -> Result<(), ImageError> {
    check_count(path, width, height, data.chunks(3).len())?;
    replace(path, &super::png::encode(path, (width, height), &data, (false, PngDepth::Eight), &[])?)
}

/// Writes sRGB code values as a PNG; always fails, because this build does not support the format.
#[cfg(not(feature = "png"))]
pub fn rgb8(path: &Path, _width: usize, _height: usize, _data: Vec<u8>) -> Result<(), ImageError> {
    Err(feature_off(path, "PNG", "png"))
}

/// Writes Radiance RGBE, with a relative error of at most 2⁻⁸ of each pixel's largest component. Negative and NaN
/// components become 0; values beyond the range of the format become its largest value, 1.7e38.
pub fn hdr(path: &Path, picture: &Image) -> Result<(), ImageError> {
    check_size(path, picture)?;
    replace(path, &super::hdr::encode(picture))
}

/// The 8-bit sRGB code values of an image (red, green, blue, row by row): multiplied by 2^`exposure`, mapped by the
/// tone curve, and rounded to nearest.
pub fn code_values(picture: &Image, tone: Tone, exposure: f32) -> Vec<u8> {
    let scale = libm::exp2f(exposure);
    let byte = |v: f32| (v * 255.0 + 0.5) as u8;
    picture.pixels.iter().flat_map(|&p| tone.apply(p * scale).to_array().map(byte)).collect()
}

/// Returns an error if `path` cannot be written: unknown extension, a format that this build does not support, missing
/// folder, a target that is not a regular file, or a folder without permission (tested with an empty temporary file).
pub fn check(path: &Path) -> Result<(), ImageError> {
    Format::of(path)?;
    probe(path)
}

fn check_size(path: &Path, picture: &Image) -> Result<(), ImageError> {
    check_count(path, picture.width, picture.height, picture.pixels.len())
}

fn check_count(path: &Path, width: usize, height: usize, count: usize) -> Result<(), ImageError> {
    let limit = crate::read::MAX_PIXELS as usize;
    let sound = count > 0 && count <= limit && width.checked_mul(height) == Some(count);
    let why = || format!("an image of {width}×{height} cannot have {count} pixels");
    if sound { Ok(()) } else { Err(ImageError::Inconsistent { path: path.to_path_buf(), why: why() }) }
}
