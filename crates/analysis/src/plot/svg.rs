//! A chart as an SVG element.

use super::canvas::{Anchor, Canvas, HEIGHT, WIDTH};
use maud::{Markup, Render, html};

/// The SVG canvas: elements in drawing order.
pub(super) struct Svg {
    title: String,
    elements: Vec<Markup>,
}

impl Svg {
    pub fn new(title: &str) -> Self {
        Self { title: title.into(), elements: Vec::new() }
    }

    pub fn finish(self) -> Markup {
        html! {
            svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (WIDTH) " " (HEIGHT) }
                font-family="system-ui, sans-serif" font-size="13" role="img" {
                title { (self.title) }
                rect width=(WIDTH) height=(HEIGHT) fill="#fff" {}
                @for element in &self.elements { (element) "\n" }
            }
        }
    }
}

/// A colour as in CSS.
struct Hex([u8; 3]);

impl Render for Hex {
    fn render_to(&self, buffer: &mut String) {
        let [r, g, b] = self.0;
        buffer.push_str(&format!("#{r:02x}{g:02x}{b:02x}"));
    }
}

fn list(points: &[(f64, f64)]) -> String {
    points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

fn tenths(x: f64) -> String {
    format!("{x:.1}")
}

impl Canvas for Svg {
    fn line(&mut self, points: &[(f64, f64)], width: f64, colour: [u8; 3], dashed: bool) {
        self.elements.push(html! {
            polyline points=(list(points)) fill="none" stroke=(Hex(colour)) stroke-width=(width)
                stroke-linejoin="round" stroke-dasharray=[dashed.then_some("5 4")] {}
        });
    }

    fn area(&mut self, points: &[(f64, f64)], colour: [u8; 3], cover: f64) {
        self.elements.push(html! {
            polygon points=(list(points)) fill=(Hex(colour)) fill-opacity=(cover) {}
        });
    }

    fn dot(&mut self, (x, y): (f64, f64), radius: f64, colour: [u8; 3]) {
        self.elements.push(html! {
            circle cx=(tenths(x)) cy=(tenths(y)) r=(radius) fill=(Hex(colour)) {}
        });
    }

    fn text(&mut self, (x, y): (f64, f64), anchor: Anchor, colour: [u8; 3], text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.elements.push(html! {
            text x=(tenths(x)) y=(tenths(y + 4.5)) text-anchor=(anchor) fill=(Hex(colour)) { (text) }
        });
    }
}
