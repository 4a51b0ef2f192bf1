//! The layout of a chart: axes, lines, bands and legend.

use super::canvas::{Anchor, Canvas, HEIGHT, WIDTH, colour};
use super::chart::{Chart, Series};

const INK: [u8; 3] = [40, 40, 40];
const GRID: [u8; 3] = [226, 226, 226];
const FINE_GRID: [u8; 3] = [243, 243, 243];

/// Left, top, right and bottom of the plotted area.
const AREA: [f64; 4] = [86.0, 64.0, 664.0, HEIGHT as f64 - 62.0];

/// A logarithmic axis: the range in powers of ten and in pixels.
#[derive(Clone, Copy)]
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// An axis over all positive `values` with a margin; at most forty decades.
    fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(libm::log10);
        let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), l| (a.min(l), b.max(l)));
        let (low, high) = if low <= high { (low, high) } else { (-1.0, 0.0) };
        let room = f64::max(0.06 * (high - low), 0.08);
        Self { low: f64::max(low, high - 40.0) - room, high: high + room, from, to }
    }

    fn at(&self, value: f64) -> f64 {
        self.from + (libm::log10(value) - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Whole decades of the range.
    fn decades(&self) -> impl Iterator<Item = i32> + use<> {
        (self.low.floor() as i32)..=(self.high.ceil() as i32)
    }

    fn shows(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&libm::log10(value))
    }

    /// Values with a label: decades, and 2 and 5 within them if there are few decades.
    fn labelled(&self) -> Vec<f64> {
        let (digits, step): (&[f64], usize) = match self.high - self.low {
            span if span < 2.2 => (&[1.0, 2.0, 5.0], 1),
            span if span < 9.0 => (&[1.0], 1),
            span => (&[1.0], (span / 6.0).ceil() as usize),
        };
        let decades = self.decades().filter(|d| d.rem_euclid(step as i32) == 0);
        let all = decades.flat_map(|d| digits.iter().map(move |m| m * libm::exp10(f64::from(d))));
        all.filter(|v| self.shows(*v)).collect()
    }

    /// Values with a minor grid line.
    fn fine(&self) -> Vec<f64> {
        if self.high - self.low > 6.0 {
            return Vec::new();
        }
        let all = self.decades().flat_map(|d| (1..10).map(move |m| f64::from(m) * libm::exp10(f64::from(d))));
        all.filter(|v| self.shows(*v)).collect()
    }
}

/// A value in as few characters as possible.
fn label(value: f64) -> String {
    if (0.9e-3..1e4).contains(&value) {
        let text = format!("{value:.3}");
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        format!("{value:.0e}")
    }
}

pub(super) fn draw(chart: &Chart, canvas: &mut dyn Canvas) {
    let [left, top, right, bottom] = AREA;
    let points = || chart.series.iter().flat_map(|s| &s.points);
    let x = Axis::over(points().map(|p| p.0), left, right);
    let y = Axis::over(points().flat_map(|p| [p.1.value, band_low(p), band_high(p)]), bottom, top);
    axes(chart, canvas, x, y);
    for (i, series) in chart.series.iter().enumerate() {
        line(series, colour(i), canvas, x, y);
    }
    legend(chart, canvas);
}

/// The lower end of the band; an interval that is not meaningful is not drawn.
fn band_low(p: &(f64, crate::statistics::Interval)) -> f64 {
    if p.1.is_known() { p.1.low } else { p.1.value }
}

fn band_high(p: &(f64, crate::statistics::Interval)) -> f64 {
    if p.1.is_known() { p.1.high } else { p.1.value }
}

fn axes(chart: &Chart, canvas: &mut dyn Canvas, x: Axis, y: Axis) {
    let [left, top, right, bottom] = AREA;
    let mut grid = |values: (Vec<f64>, Vec<f64>), colour| {
        for v in values.0 {
            canvas.line(&[(x.at(v), top), (x.at(v), bottom)], 1.0, colour, false);
        }
        for v in values.1 {
            canvas.line(&[(left, y.at(v)), (right, y.at(v))], 1.0, colour, false);
        }
    };
    grid((x.fine(), y.fine()), FINE_GRID);
    grid((x.labelled(), y.labelled()), GRID);
    for v in x.labelled() {
        canvas.text((x.at(v), bottom + 16.0), Anchor::Middle, INK, &label(v));
    }
    for v in y.labelled() {
        canvas.text((left - 8.0, y.at(v)), Anchor::End, INK, &label(v));
    }
    canvas.line(&[(left, top), (left, bottom), (right, bottom)], 1.5, INK, false);
    canvas.text((0.5 * (left + right), bottom + 42.0), Anchor::Middle, INK, &chart.x_label);
    canvas.text((left - 70.0, top - 18.0), Anchor::Start, INK, &chart.y_label);
    canvas.text((WIDTH as f64 * 0.5, 20.0), Anchor::Middle, INK, &chart.title);
}

fn line(series: &Series, colour: [u8; 3], canvas: &mut dyn Canvas, x: Axis, y: Axis) {
    let usable = |p: &&(f64, crate::statistics::Interval)| x.shows(p.0) && y.shows(p.1.value);
    let points: Vec<_> = series.points.iter().filter(usable).collect();
    let middle: Vec<_> = points.iter().map(|p| (x.at(p.0), y.at(p.1.value))).collect();
    if series.guide {
        canvas.line(&middle, 1.2, [120; 3], true);
        return;
    }
    let low = points.iter().map(|p| (x.at(p.0), y.at(band_low(p)).min(AREA[3])));
    let high = points.iter().rev().map(|p| (x.at(p.0), y.at(band_high(p)).max(AREA[1])));
    canvas.area(&low.chain(high).collect::<Vec<_>>(), colour, 0.18);
    canvas.line(&middle, 2.2, colour, false);
    middle.iter().for_each(|at| canvas.dot(*at, 3.6, colour));
}

fn legend(chart: &Chart, canvas: &mut dyn Canvas) {
    let left = AREA[2] + 18.0;
    for (i, series) in chart.series.iter().enumerate() {
        let y = AREA[1] + 8.0 + 22.0 * i as f64;
        let ink = if series.guide { [120; 3] } else { colour(i) };
        canvas.line(&[(left, y), (left + 24.0, y)], 2.2, ink, series.guide);
        if !series.guide {
            canvas.dot((left + 12.0, y), 3.6, ink);
        }
        let name: String = series.name.chars().take(22).collect();
        canvas.text((left + 32.0, y), Anchor::Start, INK, &name);
    }
}
