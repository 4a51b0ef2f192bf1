//! Images in memory: linear Rec. 709 RGB in f32, row by row from the top left.

use glam::{DVec3, Vec3};

/// One linear colour per pixel, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` colours; pixel (x, y) is at `y * width + x`.
    pub pixels: Vec<Vec3>,
}

impl Image {
    /// An image of one colour.
    #[must_use]
    pub fn filled(width: usize, height: usize, colour: Vec3) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// The pixel in column `x` and row `y`, which must be inside.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> Vec3 {
        self.pixels[y * self.width + x]
    }

    /// Mean over all pixels, summed in f64; 0 without pixels.
    #[must_use]
    pub fn mean(&self) -> Vec3 {
        let sum: DVec3 = self.pixels.iter().map(|p| p.as_dvec3()).sum();
        (sum / self.pixels.len().max(1) as f64).as_vec3()
    }
}
