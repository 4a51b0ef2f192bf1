//! Undecoded texels of 8 or 16 bits per channel, as stored in a file.

/// Texels of 8 bits per channel, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgba8 {
    /// Texels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` texels as red, green, blue, alpha.
    pub texels: Vec<[u8; 4]>,
}

/// Texels of 16 bits per channel, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgba16 {
    /// Texels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` texels as red, green, blue, alpha.
    pub texels: Vec<[u16; 4]>,
}

/// The texels of an image, with the bit depth that its values require.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Texels {
    /// 8 bits per channel.
    Eight(Rgba8),
    /// 16 bits per channel, if 8 would lose precision.
    Sixteen(Rgba16),
}

impl Texels {
    /// Width and height in texels.
    pub fn size(&self) -> (usize, usize) {
        match self {
            Self::Eight(image) => (image.width, image.height),
            Self::Sixteen(image) => (image.width, image.height),
        }
    }

    /// Memory of the texels in bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Eight(image) => size_of_val(&*image.texels),
            Self::Sixteen(image) => size_of_val(&*image.texels),
        }
    }
}

impl From<Rgba8> for Texels {
    fn from(image: Rgba8) -> Self {
        Self::Eight(image)
    }
}

/// Converts to 8 bits if this is lossless: all values are multiples of 257, as in an 8-bit image saved with 16 bits.
impl From<Rgba16> for Texels {
    fn from(image: Rgba16) -> Self {
        if image.texels.as_flattened().iter().any(|value| value % 257 != 0) {
            return Self::Sixteen(image);
        }
        let texels = image.texels.iter().map(|texel| texel.map(|value| (value / 257) as u8)).collect();
        Self::Eight(Rgba8 { width: image.width, height: image.height, texels })
    }
}
