//! What a plot shows: its lines and the words around them.

use crate::statistics::Interval;

/// A line with its band.
#[derive(Clone, Debug)]
pub struct Series {
    /// For the legend.
    pub name: String,
    /// Positive x, and y with its interval, in order of x.
    pub points: Vec<(f64, Interval)>,
    /// Drawn thin and dashed, without marks: a line to compare with.
    pub guide: bool,
}

/// A plot.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Over it.
    pub title: String,
    /// Under the x axis.
    pub x_label: String,
    /// Over the y axis.
    pub y_label: String,
    /// The lines, in the order of the legend.
    pub series: Vec<Series>,
}
