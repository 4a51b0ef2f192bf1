//! Pictures in memory: linear Rec.709 RGB, row by row from the top left.

use glam::Vec3;

/// One colour per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// `width`·`height` of them.
    pub pixels: Vec<Vec3>,
}

impl Picture {
    /// All pixels the same.
    pub fn filled(width: usize, height: usize, color: Vec3) -> Self {
        Self { width, height, pixels: vec![color; width * height] }
    }

    /// The pixel at (x, y) from the top left.
    pub fn at(&self, x: usize, y: usize) -> Vec3 {
        self.pixels[y * self.width + x]
    }

    /// Mean over all pixels, in f64.
    pub fn mean(&self) -> Vec3 {
        let sum: glam::DVec3 = self.pixels.iter().map(|p| p.as_dvec3()).sum();
        (sum / self.pixels.len().max(1) as f64).as_vec3()
    }
}

/// Named channels of one kind, e.g. "normal" with X, Y, Z. The layer without a name is the beauty, with R, G, B.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Empty for the beauty.
    pub name: String,
    /// Channel name and its values, one per pixel.
    pub channels: Vec<(String, Vec<f32>)>,
}

/// What an EXR holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Pixels across the data.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Where a crop's data lie within the full picture.
    pub offset: (i32, i32),
    /// The full picture; (0, 0) = the data are all of it.
    pub full_size: (usize, usize),
    /// All of `width`·`height` pixels.
    pub layers: Vec<Layer>,
    /// Named facts to store with the picture.
    pub metadata: Vec<(String, MetaValue)>,
}

impl Layers {
    /// The layer without a name as a picture; None without R, G, B.
    pub fn beauty(&self) -> Option<Picture> {
        let layer = self.layers.iter().find(|l| l.name.is_empty()).or(self.layers.first())?;
        let channel = |name: &str| layer.channels.iter().find(|(n, _)| n == name).map(|(_, values)| values);
        let (r, g, b) = match (channel("R"), channel("G"), channel("B"), channel("Y")) {
            (Some(r), Some(g), Some(b), _) => (r, g, b),
            (_, _, _, Some(y)) => (y, y, y),
            _ => return None,
        };
        let pixels = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| Vec3::new(r, g, b)).collect();
        Some(Picture { width: self.width, height: self.height, pixels })
    }
}

impl From<&Picture> for Layers {
    fn from(picture: &Picture) -> Self {
        let channel = |name: &str, i: usize| (name.into(), picture.pixels.iter().map(|p| p[i]).collect());
        let beauty =
            Layer { name: String::new(), channels: vec![channel("R", 0), channel("G", 1), channel("B", 2)] };
        Self { width: picture.width, height: picture.height, layers: vec![beauty], ..Self::default() }
    }
}

/// A fact stored with a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum MetaValue {
    /// Text.
    Text(String),
    /// Whole number.
    Int(i32),
    /// Number.
    Float(f32),
    /// 4×4 matrix, row by row.
    Matrix([f32; 16]),
}
