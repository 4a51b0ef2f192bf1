//! The contents of a plot: its lines and labels.

use crate::statistics::Interval;

/// A line with its confidence band.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Positive x, and y with its interval, in increasing order of x.
    pub points: Vec<(f64, Interval)>,
    /// Whether the line is a guide, drawn thin and dashed without markers.
    pub guide: bool,
}

/// A plot.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Title above the plot.
    pub title: String,
    /// Label below the x axis.
    pub x_label: String,
    /// Label above the y axis.
    pub y_label: String,
    /// The lines, in the order of the legend.
    pub series: Vec<Series>,
}
