//! What can be chosen about the file of a picture.

use crate::Tone;

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
