//! Which part of its frame does a picture hold?
//!
//! An EXR says how large the full picture is (the display window) and which pixels of it are there (the data window):
//! a crop knows where it belongs. What it does not hold is not black, it is not known, and must not be compared.

/// A rectangle of pixels of a full picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First column.
    pub x: usize,
    /// First row from the top.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Window {
    /// All of a picture of that size.
    pub fn full((width, height): (usize, usize)) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// One past the last column and row.
    pub fn end(&self) -> (usize, usize) {
        (self.x + self.width, self.y + self.height)
    }

    /// The pixels in both; `None` when there are none.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let (a, b) = (self.end(), other.end());
        let (right, bottom) = (a.0.min(b.0), a.1.min(b.1));
        (x < right && y < bottom).then(|| Self { x, y, width: right - x, height: bottom - y })
    }
}

/// As in an error message: first column and row, then one past the last.
impl std::fmt::Display for Window {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (right, bottom) = self.end();
        write!(f, "{},{} to {right},{bottom}", self.x, self.y)
    }
}

/// A crop where more of the picture is needed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}: holds the pixels {has} of {}x{}, and {wanted} are needed; render them too", .full_size.0, .full_size.1)]
pub struct Partial {
    /// The file.
    pub name: String,
    /// What is there.
    pub has: Window,
    /// What is needed.
    pub wanted: Window,
    /// Width and height of the full picture.
    pub full_size: (usize, usize),
}
