//! Images in memory: linear Rec. 709 RGB in f32, in row-major order from the top left.

use glam::{DVec3, Vec3};

/// An image with one linear colour per pixel, in row-major order from the top left.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Image {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// The `width * height` colours; pixel (x, y) has index `y * width + x`.
    pub pixels: Vec<Vec3>,
}

impl Image {
    /// Creates an image of one colour.
    #[must_use]
    pub fn filled(width: usize, height: usize, colour: Vec3) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// Returns the pixel in column `x` and row `y`, which must lie inside the image.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> Vec3 {
        self.pixels[y * self.width + x]
    }

    /// Returns the mean over all pixels, summed in f64. It is 0 if there are no pixels.
    #[must_use]
    pub fn mean(&self) -> Vec3 {
        let sum: DVec3 = self.pixels.iter().map(|p| p.as_dvec3()).sum();
        (sum / self.pixels.len().max(1) as f64).as_vec3()
    }
}
