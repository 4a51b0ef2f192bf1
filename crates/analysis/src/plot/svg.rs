//! SVG output of a chart.

use super::canvas::{Anchor, Canvas, HEIGHT, WIDTH};
use std::fmt::Write;

/// The SVG canvas.
pub(super) struct Svg(String);

impl Svg {
    pub fn new(title: &str) -> Self {
        let title = escaped(title);
        Self(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
             font-family=\"system-ui, sans-serif\" font-size=\"13\" role=\"img\">\n<title>{title}</title>\n\
             <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n"
        ))
    }

    pub fn finish(mut self) -> String {
        self.0.push_str("</svg>\n");
        self.0
    }

    fn element(&mut self, text: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.0.write_fmt(text);
        self.0.push('\n');
    }
}

/// Escapes text for use between tags or in attributes.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn list(points: &[(f64, f64)]) -> String {
    points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

impl Canvas for Svg {
    fn line(&mut self, points: &[(f64, f64)], width: f64, colour: [u8; 3], dashed: bool) {
        let dash = if dashed { " stroke-dasharray=\"5 4\"" } else { "" };
        self.element(format_args!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{dash}/>",
            list(points),
            hex(colour),
        ));
    }

    fn area(&mut self, points: &[(f64, f64)], colour: [u8; 3], cover: f64) {
        let points = list(points);
        self.element(format_args!(
            "<polygon points=\"{points}\" fill=\"{}\" fill-opacity=\"{cover}\"/>",
            hex(colour)
        ));
    }

    fn dot(&mut self, (x, y): (f64, f64), radius: f64, colour: [u8; 3]) {
        self.element(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{}\"/>",
            hex(colour)
        ));
    }

    fn text(&mut self, (x, y): (f64, f64), anchor: Anchor, colour: [u8; 3], text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.element(format_args!(
            "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\" fill=\"{}\">{}</text>",
            y + 4.5,
            hex(colour),
            escaped(text),
        ));
    }
}
