//! Images of 8-bit code values, as they are shown on a screen.

use crate::{Image, Tone, write};

/// 8-bit sRGB code values (red, green, blue), row by row from the top left.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Frame {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height * 3` code values, as accepted by [`write::rgb8`].
    pub data: Vec<u8>,
}

impl Frame {
    /// Converts an image with an exposure (in stops) and a tone curve.
    pub fn of(picture: &Image, tone: Tone, exposure: f32) -> Self {
        Self {
            width: picture.width,
            height: picture.height,
            data: write::code_values(picture, tone, exposure),
        }
    }
}
