//! Pixel windows: the part of the full image that a file contains.
//!
//! An EXR stores the size of the full image (the display window) and which of its pixels are present (the data window),
//! so that a crop contains its position. Pixels outside of the data window are not black but unknown, and must not be
//! compared.

/// A rectangle of pixels of a full image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The first column.
    pub x: usize,
    /// The first row from the top.
    pub y: usize,
    /// The number of columns.
    pub width: usize,
    /// The number of rows.
    pub height: usize,
}

impl Window {
    /// The window of a full image of the given size.
    pub fn full((width, height): (usize, usize)) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// One past the last column and row.
    pub fn end(&self) -> (usize, usize) {
        (self.x + self.width, self.y + self.height)
    }

    /// The pixels in both windows; `None` when there are none.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let (a, b) = (self.end(), other.end());
        let (right, bottom) = (a.0.min(b.0), a.1.min(b.1));
        (x < right && y < bottom).then(|| Self { x, y, width: right - x, height: bottom - y })
    }
}

/// Formats the window for error messages: first column and row, then one past the last.
impl std::fmt::Display for Window {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (right, bottom) = self.end();
        write!(f, "{},{} to {right},{bottom}", self.x, self.y)
    }
}

/// The error for a crop that does not contain all required pixels.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}: has only pixels {has} of {}x{}, but {wanted} are needed; render them too", .full_size.0, .full_size.1)]
pub struct Partial {
    /// The file.
    pub name: String,
    /// The window of the file.
    pub has: Window,
    /// The required window.
    pub wanted: Window,
    /// Width and height of the full image.
    pub full_size: (usize, usize),
}
