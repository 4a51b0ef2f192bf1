//! Options for writing image files.

use crate::Tone;

/// The number of bits of an EXR's colour channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Depth {
    /// 32-bit floats for all channels: the computed values, bit for bit.
    #[default]
    Float,
    /// 16-bit floats for colour (channels R, G, B, A of every layer except "variance" and those of a Cryptomatte, whose
    /// ids are the bits of their floats) and for the layer "normal". All other channels (positions, depths, ids,
    /// counts) remain 32-bit, because half represents integers exactly only up to 2048. Values are rounded to nearest
    /// even; finite values beyond ±65504 become ±65504, not infinite.
    Half,
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

/// Options for converting a linear image to a PNG.
#[derive(Clone, Copy, Debug, Default)]
pub struct PngOptions<'a> {
    /// The tone curve.
    pub tone: Tone,
    /// The exposure in stops.
    pub exposure: f32,
    /// Bits per channel.
    pub depth: PngDepth,
    /// The coverage of each pixel, whose colour is then associated (premultiplied). The format requires unassociated
    /// colours [PNG 2003, §12.3], so they are divided by the coverage before exposure and tone curve. Coverage is
    /// clamped to 0 and 1, and where it is 0 the colour is black.
    pub alpha: Option<&'a [f32]>,
    /// Keywords and texts of the file's metadata.
    pub texts: &'a [(&'a str, &'a str)],
}
