//! The drawing interface: the size of a plot, its colours, and the primitives of SVG and raster output.

/// Width of a plot in pixels.
pub const WIDTH: usize = 900;
/// Height of a plot in pixels.
pub const HEIGHT: usize = 520;

/// Colours that can be distinguished with all kinds of colour vision [Wong 2011]; they repeat after the last one.
pub(crate) const COLOURS: [[u8; 3]; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 180, 233],
    [230, 159, 0],
    [90, 90, 90],
];

/// The colour of the i-th series.
pub fn colour(i: usize) -> [u8; 3] {
    COLOURS[i % COLOURS.len()]
}

/// The point of a text that is placed at the given position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// Drawing primitives. Coordinates are in pixels from the top left.
pub(crate) trait Canvas {
    /// A polyline.
    fn line(&mut self, points: &[(f64, f64)], width: f64, colour: [u8; 3], dashed: bool);
    /// A filled polygon of opacity `cover`, 0 to 1.
    fn area(&mut self, points: &[(f64, f64)], colour: [u8; 3], cover: f64);
    /// A filled circle.
    fn dot(&mut self, at: (f64, f64), radius: f64, colour: [u8; 3]);
    /// One line of text, vertically centred at `at.1`.
    fn text(&mut self, at: (f64, f64), anchor: Anchor, colour: [u8; 3], text: &str);
}
