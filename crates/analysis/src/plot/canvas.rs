//! What can be drawn on: the size of a plot, its colours, and the primitives that SVG and pixels both know.

/// Pixels across.
pub const WIDTH: usize = 900;
/// Pixels down.
pub const HEIGHT: usize = 520;

/// Colours that people of all kinds of colour vision tell apart [Wong 2011], then again.
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

/// Which end of a text is at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// What can be drawn; pixels from the top left.
pub(crate) trait Canvas {
    /// Straight lines from point to point.
    fn line(&mut self, points: &[(f64, f64)], width: f64, colour: [u8; 3], dashed: bool);
    /// A filled shape; `cover` 0 = nothing, 1 = opaque.
    fn area(&mut self, points: &[(f64, f64)], colour: [u8; 3], cover: f64);
    /// A filled circle.
    fn dot(&mut self, at: (f64, f64), radius: f64, colour: [u8; 3]);
    /// One line of text with its middle at the height `at.1`.
    fn text(&mut self, at: (f64, f64), anchor: Anchor, colour: [u8; 3], text: &str);
}
