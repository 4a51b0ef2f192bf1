//! Rectangles of pixels.

/// The pixels with x0 ≤ x < x1 and y0 ≤ y < y1. Pixel (0, 0) is at the top left of the full image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PixelRect {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// One past the last column.
    pub x1: u32,
    /// One past the last row.
    pub y1: u32,
}
impl PixelRect {
    /// Returns the number of columns.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.x1.saturating_sub(self.x0)
    }
    /// Returns the number of rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.y1.saturating_sub(self.y0)
    }
    /// Returns the number of pixels.
    #[must_use]
    pub fn area(&self) -> usize {
        self.width() as usize * self.height() as usize
    }
    /// Returns whether pixel (x, y) lies inside.
    #[inline]
    #[must_use]
    pub fn contains(&self, x: u32, y: u32) -> bool {
        x >= self.x0 && x < self.x1 && y >= self.y0 && y < self.y1
    }
    /// Returns the pixels common to both rectangles. Its width or height is zero when there are none.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }
}
