//! Log-log plots of lines with bands, as SVG and as raster images.
//!
//! A [`Chart`] contains the data. It is laid out once, in drawing primitives that both implementations of `Canvas`
//! support.

mod canvas;
mod chart;
mod layout;
mod raster;
mod svg;

pub use canvas::{HEIGHT, WIDTH, colour};
pub use chart::{Chart, Series};

use dapple_imaging::Frame;
use maud::Markup;

impl Chart {
    /// The plot as a self-contained `<svg>` element.
    pub fn svg(&self) -> String {
        self.markup().into_string()
    }

    /// The plot as a part of a page.
    pub(crate) fn markup(&self) -> Markup {
        let mut canvas = svg::Svg::new(&self.title);
        layout::draw(self, &mut canvas);
        canvas.finish()
    }

    /// The plot as a raster image.
    pub fn frame(&self) -> Frame {
        let mut canvas = raster::Raster::new();
        layout::draw(self, &mut canvas);
        canvas.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::canvas::COLOURS;
    use super::*;
    use crate::statistics::Interval;

    fn chart() -> Chart {
        let point = |k: i32| {
            let (x, y) = (f64::from(1 << k) * 0.01, 0.5 / f64::from(1 << k));
            (x, Interval { value: y, low: 0.8 * y, high: 1.25 * y })
        };
        let series =
            |name: &str, guide| Series { name: name.into(), points: (0..9).map(point).collect(), guide };
        Chart {
            title: "a < b & c".into(),
            x_label: "seconds".into(),
            y_label: "error".into(),
            series: vec![series("one", false), series("N^-1", true)],
        }
    }

    #[test]
    fn both_kinds_show_the_same_marks() {
        let svg = chart().svg();
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>") && svg.contains("a &lt; b &amp; c"));
        assert_eq!(svg.matches("<circle").count(), 9 + 1);
        let frame = chart().frame();
        assert_eq!((frame.width, frame.height, frame.data.len()), (WIDTH, HEIGHT, WIDTH * HEIGHT * 3));
        let ink = frame.data.chunks_exact(3).filter(|p| *p == COLOURS[0]).count();
        assert!(ink > 9 * 20, "{ink}");
    }

    #[test]
    fn odd_charts_are_no_reason_to_stop() {
        let odd = |points: Vec<(f64, Interval)>| Chart {
            series: vec![Series { name: String::new(), points, guide: false }],
            ..chart()
        };
        let all = |value| Interval { value, low: f64::NEG_INFINITY, high: f64::INFINITY };
        let cases = [
            vec![],
            vec![(1.0, all(1.0))],
            vec![(0.0, all(1.0)), (-1.0, all(0.0)), (1.0, all(f64::NAN))],
            vec![(1e-300, all(1e300)), (1e300, all(1e-300))],
        ];
        for points in cases {
            let chart = odd(points);
            assert!(!chart.svg().contains("NaN") && !chart.svg().contains("inf"));
            chart.frame();
        }
        assert_eq!(Chart { series: vec![], ..chart() }.frame().width, WIDTH);
    }
}
