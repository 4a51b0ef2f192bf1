//! How does a picture become a file?
//!
//! Every file is written under a temporary name beside its target and renamed when it is whole: whoever looks at
//! the target sees the old file or the new one, never a part, and a failure leaves nothing behind; what a killed
//! process leaves, [`check`] removes the next time. The bytes
//! depend on the picture alone: not on machine, thread count, time or path.

#[cfg(feature = "exr")]
mod exr;
mod file;
mod hdr;
#[cfg(feature = "png")]
mod png;

pub use file::{elsewhere, probe, replace};

use crate::{Image, ImageError, Layers, Tone};
use std::path::Path;

/// How many bits an EXR spends on colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Depth {
    /// 32-bit floats throughout: what was computed, bit for bit.
    #[default]
    Float,
    /// 16-bit floats for colour (channels R, G, B, A of every layer but "variance" and those of a Cryptomatte, whose ids
    /// are the bits of their floats) and for the layer "normal";
    /// all other channels (positions, depths, ids, counts) stay 32-bit, for half holds whole numbers only up to
    /// 2048. Rounded to nearest even; finite values beyond ±65504 become ±65504, not infinite.
    Half,
}

/// The format of an output, decided by its extension.
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
    /// By extension, in any case of letters; an error if there is none, it is unknown, or this build leaves it out.
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

fn feature_off(path: &Path, format: &'static str, feature: &'static str) -> ImageError {
    ImageError::NotBuiltIn { name: path.display().to_string(), format, feature }
}

/// Writes all layers as one part of an EXR: ZIP in blocks of 16 rows, no alpha unless a layer has one, channels
/// called `layer.channel`, Rec.709 chromaticities, the metadata as attributes. A crop keeps its data window within
/// the display window. Compression uses as many threads as the rayon pool it is called from.
#[cfg(feature = "exr")]
pub fn exr(path: &Path, layers: &Layers, depth: Depth) -> Result<(), ImageError> {
    replace(path, &exr::encode(path, layers, depth)?)
}

/// Writes all layers as one part of an EXR; this build leaves the format out, so it always fails.
#[cfg(not(feature = "exr"))]
pub fn exr(path: &Path, _layers: &Layers, _depth: Depth) -> Result<(), ImageError> {
    Err(feature_off(path, "EXR", "exr"))
}

/// Bits per channel of a PNG.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum PngDepth {
    /// 8.
    #[default]
    Eight,
    /// 16.
    Sixteen,
}

/// How a linear picture becomes a PNG.
#[derive(Clone, Copy, Debug, Default)]
pub struct PngOptions<'a> {
    /// The curve from light to code values.
    pub tone: Tone,
    /// In stops.
    pub exposure: f32,
    /// Bits per channel.
    pub depth: PngDepth,
    /// Coverage of each pixel, whose colours are then associated (premultiplied); the format wants them unassociated
    /// [PNG 2003, §12.3], so they are divided by it before exposure and tone curve. Beyond 0 and 1 it is cut, and where
    /// it is 0 the colour is black.
    pub alpha: Option<&'a [f32]>,
    /// Keyword and text of what the file says about itself.
    pub texts: &'a [(&'a str, &'a str)],
}

/// Writes an 8-bit PNG of [`code_values`]: exposure in stops, tone curve, rounding to nearest.
pub fn png(path: &Path, picture: &Image, tone: Tone, exposure: f32) -> Result<(), ImageError> {
    png_with(path, picture, &PngOptions { tone, exposure, ..PngOptions::default() })
}

/// As [`png`], with all that a PNG can have. The file says that its values are sRGB.
#[cfg(feature = "png")]
pub fn png_with(path: &Path, picture: &Image, options: &PngOptions<'_>) -> Result<(), ImageError> {
    check_size(path, picture)?;
    let unlike = options.alpha.filter(|alpha| alpha.len() != picture.pixels.len());
    if let Some(alpha) = unlike {
        let why = format!("{} pixels cannot have the coverage of {}", picture.pixels.len(), alpha.len());
        return Err(ImageError::Inconsistent { path: path.to_path_buf(), why });
    }
    let encoded = match options.depth {
        PngDepth::Eight => png::of(picture, options, |v| [(v * 255.0 + 0.5) as u8]),
        PngDepth::Sixteen => png::of(picture, options, |v| ((v * 65_535.0 + 0.5) as u16).to_ne_bytes()),
    };
    let kind = (options.alpha.is_some(), options.depth);
    replace(path, &png::encode(path, (picture.width, picture.height), &encoded, kind, options.texts)?)
}

/// Writes a PNG; this build leaves the format out, so it always fails.
#[cfg(not(feature = "png"))]
pub fn png_with(path: &Path, _picture: &Image, _options: &PngOptions<'_>) -> Result<(), ImageError> {
    Err(feature_off(path, "PNG", "png"))
}

/// Writes finished sRGB code values, red, green, blue, row by row from the top left, as an 8-bit PNG.
#[cfg(feature = "png")]
pub fn rgb8(path: &Path, width: usize, height: usize, data: Vec<u8>) -> Result<(), ImageError> {
    check_count(path, width, height, data.chunks(3).len())?;
    replace(path, &png::encode(path, (width, height), &data, (false, PngDepth::Eight), &[])?)
}

/// Writes finished code values as a PNG; this build leaves the format out, so it always fails.
#[cfg(not(feature = "png"))]
pub fn rgb8(path: &Path, _width: usize, _height: usize, _data: Vec<u8>) -> Result<(), ImageError> {
    Err(feature_off(path, "PNG", "png"))
}

/// Writes Radiance RGBE: relative error at most 2⁻⁸ of each pixel's largest component; negative and NaN
/// components become 0, values beyond the format's range its largest, 1.7e38.
pub fn hdr(path: &Path, picture: &Image) -> Result<(), ImageError> {
    check_size(path, picture)?;
    replace(path, &hdr::encode(picture))
}

/// The 8-bit sRGB code values of a picture, red, green, blue, row by row: times 2^`exposure`, through the tone
/// curve, rounded to nearest.
pub fn code_values(picture: &Image, tone: Tone, exposure: f32) -> Vec<u8> {
    let scale = libm::exp2f(exposure);
    let byte = |v: f32| (v * 255.0 + 0.5) as u8;
    picture.pixels.iter().flat_map(|&p| tone.apply(p * scale).to_array().map(byte)).collect()
}

/// Fails early when `path` cannot be written: unknown extension or a format this build leaves out, missing folder,
/// a target that is no plain file, a folder without permission (tried with an empty temporary file).
pub fn check(path: &Path) -> Result<(), ImageError> {
    Format::of(path)?;
    file::probe(path)
}

fn check_size(path: &Path, picture: &Image) -> Result<(), ImageError> {
    check_count(path, picture.width, picture.height, picture.pixels.len())
}

fn check_count(path: &Path, width: usize, height: usize, count: usize) -> Result<(), ImageError> {
    let limit = crate::read::MAX_PIXELS as usize;
    let sound = count > 0 && count <= limit && width.checked_mul(height) == Some(count);
    let why = || format!("a picture of {width}×{height} cannot have {count} pixels");
    if sound { Ok(()) } else { Err(ImageError::Inconsistent { path: path.to_path_buf(), why: why() }) }
}
