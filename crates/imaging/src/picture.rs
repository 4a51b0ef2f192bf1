//! Images with layers in memory.
//!
//! Values are linear Rec.709 RGB radiance in f32, row by row from the top left. An [`Image`] has one colour per pixel;
//! [`Layers`] correspond to the content of an EXR, which has any number of named channels in the same window.

use dapple_math::Image;
use glam::Vec3;

/// A group of channels, e.g. with the name "normal" and the channels X, Y, Z. The name "" is that of the beauty layer
/// with the channels R, G, B. In the file a channel is called `name.channel`, as Nuke and Blender expect.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The part of the channels' names before the last dot.
    pub name: String,
    /// Channel name and `width * height` values, row by row from the top left.
    pub channels: Vec<(String, Vec<f32>)>,
}

/// The content of an EXR.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Pixels per row of the data window.
    pub width: usize,
    /// Rows of the data window.
    pub height: usize,
    /// Top-left corner of the data window within the full image; (0, 0) unless this is a crop.
    pub offset: (i32, i32),
    /// Size of the full image (the display window). (0, 0) means `(width, height)`.
    pub full_size: (usize, usize),
    /// The layers, in any order; the file has them in order of name, as the format requires.
    pub layers: Vec<Layer>,
    /// Attributes by name, in any order; the file has them in order of name, so that equal content gives equal bytes.
    pub metadata: Vec<(String, MetaValue)>,
}

impl Layers {
    /// The layer with the given name.
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.name == name)
    }

    /// The layer without a name, or else the first one, as an image of the data window; see [`picture`](Self::picture).
    pub fn beauty(&self) -> Option<Image> {
        self.picture("").or_else(|| self.picture(&self.layers.first()?.name))
    }

    /// The data window of the layer `name` as an image: its R, G, B, or else X, Y, Z, or else Y or its only channel
    /// three times. `None` if there is no such layer or it has none of these channels.
    pub fn picture(&self, name: &str) -> Option<Image> {
        let layer = self.layer(name)?;
        let find = |c: &str| layer.channels.iter().find(|(n, _)| n == c).map(|(_, v)| v.as_slice());
        let three = |a, b, c| Some([find(a)?, find(b)?, find(c)?]);
        let only = match &layer.channels[..] {
            [(_, only)] => Some(only.as_slice()),
            _ => find("Y"),
        };
        let [r, g, b] =
            three("R", "G", "B").or_else(|| three("X", "Y", "Z")).or_else(|| only.map(|y| [y; 3]))?;
        let pixels = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| Vec3::new(r, g, b)).collect();
        Some(Image { width: self.width, height: self.height, pixels })
    }
}

/// An image becomes the beauty layer of a file without other layers.
impl From<&Image> for Layers {
    fn from(picture: &Image) -> Self {
        let channel =
            |name: &str, i: usize| (name.to_string(), picture.pixels.iter().map(|p| p[i]).collect());
        let beauty =
            Layer { name: String::new(), channels: vec![channel("R", 0), channel("G", 1), channel("B", 2)] };
        Self { width: picture.width, height: picture.height, layers: vec![beauty], ..Self::default() }
    }
}

/// The value of an EXR attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum MetaValue {
    /// UTF-8 text.
    Text(String),
    /// A 32-bit integer.
    Int(i32),
    /// A 32-bit float.
    Float(f32),
    /// A 4×4 matrix in the order of the file: row by row for row vectors (p' = p M, so that a translation is in the
    /// elements 12, 13, 14). This is also glam's column-by-column order for column vectors (`Mat4::to_cols_array`). The
    /// standard attributes `worldToCamera` and `worldToNDC` are of this type.
    Matrix([f32; 16]),
}
