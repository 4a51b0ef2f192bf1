//! Raster output of a chart: shapes are drawn at three times the resolution and averaged, text is drawn afterwards.

use super::canvas::{Anchor, Canvas, HEIGHT, WIDTH};
use dapple_imaging::sheet::Frame;
use dapple_imaging::text;

/// Subpixels per pixel along each axis.
const FINE: usize = 3;
/// Font size in pixels.
const SIZE: f32 = 14.0;

/// Position, anchor, colour and text.
type Text = ((f64, f64), Anchor, [u8; 3], String);

/// The raster canvas.
pub(super) struct Raster {
    /// Code values of the subpixels.
    dots: Vec<[u8; 3]>,
    texts: Vec<Text>,
}

impl Raster {
    pub fn new() -> Self {
        Self { dots: vec![[255; 3]; WIDTH * FINE * HEIGHT * FINE], texts: Vec::new() }
    }

    pub fn finish(self) -> Frame {
        let mean = |x: usize, y: usize, c: usize| {
            let block = (0..FINE).flat_map(|j| (0..FINE).map(move |i| (x * FINE + i, y * FINE + j)));
            let sum: u32 = block.map(|(x, y)| u32::from(self.dots[y * WIDTH * FINE + x][c])).sum();
            (sum / (FINE * FINE) as u32) as u8
        };
        let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
        let data = pixels.flat_map(|(x, y)| [0, 1, 2].map(|c| mean(x, y, c))).collect();
        let mut frame = Frame { width: WIDTH, height: HEIGHT, data };
        for ((x, y), anchor, colour, words) in &self.texts {
            let width = text::width(words, SIZE);
            let left = match anchor {
                Anchor::Start => *x as f32,
                Anchor::Middle => *x as f32 - 0.5 * width,
                Anchor::End => *x as f32 - width,
            };
            let top = *y as f32 - 0.5 * text::line_height(SIZE) as f32;
            text::draw(&mut frame, (left.max(0.0), top.max(0.0)), SIZE, *colour, words);
        }
        frame
    }

    fn mix(&mut self, x: usize, y: usize, colour: [u8; 3], cover: f64) {
        if x < WIDTH * FINE && y < HEIGHT * FINE {
            let dot = &mut self.dots[y * WIDTH * FINE + x];
            for (old, new) in dot.iter_mut().zip(colour) {
                *old = (f64::from(*old) * (1.0 - cover) + f64::from(new) * cover + 0.5) as u8;
            }
        }
    }

    /// Fills a closed polygon, row by row of subpixels.
    fn fill(&mut self, points: &[(f64, f64)], colour: [u8; 3], cover: f64) {
        let fine = |v: f64| (v * FINE as f64).clamp(0.0, (WIDTH * FINE) as f64);
        let points: Vec<(f64, f64)> = points.iter().map(|p| (fine(p.0), fine(p.1))).collect();
        let ys = points.iter().map(|p| p.1);
        let (low, high) = ys.fold((f64::INFINITY, 0.0f64), |(a, b), y| (a.min(y), b.max(y)));
        if points.len() < 3 {
            return;
        }
        for row in low as usize..=(high as usize).min(HEIGHT * FINE - 1) {
            let y = row as f64 + 0.5;
            let edges = points.iter().zip(points.iter().cycle().skip(1));
            let crossed = edges.filter(|(a, b)| (a.1 <= y) != (b.1 <= y));
            let mut xs: Vec<f64> =
                crossed.map(|(a, b)| a.0 + (y - a.1) / (b.1 - a.1) * (b.0 - a.0)).collect();
            xs.sort_by(f64::total_cmp);
            for pair in xs.chunks_exact(2) {
                for x in (pair[0] + 0.5) as usize..(pair[1] + 0.5) as usize {
                    self.mix(x, row, colour, cover);
                }
            }
        }
    }

    fn stroke(&mut self, a: (f64, f64), b: (f64, f64), width: f64, colour: [u8; 3]) {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let length = f64::max((dx * dx + dy * dy).sqrt(), 1e-9);
        let (nx, ny) = (-dy / length * 0.5 * width, dx / length * 0.5 * width);
        let corners =
            [(a.0 + nx, a.1 + ny), (b.0 + nx, b.1 + ny), (b.0 - nx, b.1 - ny), (a.0 - nx, a.1 - ny)];
        self.fill(&corners, colour, 1.0);
    }
}

impl Canvas for Raster {
    fn line(&mut self, points: &[(f64, f64)], width: f64, colour: [u8; 3], dashed: bool) {
        for pair in points.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            if !dashed {
                self.stroke(a, b, width, colour);
                continue;
            }
            let steps = (((b.0 - a.0).powi(2) + (b.1 - a.1).powi(2)).sqrt() / 4.5).max(1.0) as usize;
            let at = |i: usize| {
                let t = i as f64 / steps as f64;
                (a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t)
            };
            (0..steps).step_by(2).for_each(|i| self.stroke(at(i), at(i + 1), width, colour));
        }
        if width > 2.0 {
            points.iter().for_each(|at| self.dot(*at, 0.5 * width, colour));
        }
    }

    fn area(&mut self, points: &[(f64, f64)], colour: [u8; 3], cover: f64) {
        self.fill(points, colour, cover);
    }

    fn dot(&mut self, (x, y): (f64, f64), radius: f64, colour: [u8; 3]) {
        let corner = |i: usize| {
            let angle = i as f64 * std::f64::consts::TAU / 24.0;
            (x + radius * libm::cos(angle), y + radius * libm::sin(angle))
        };
        self.fill(&(0..24).map(corner).collect::<Vec<_>>(), colour, 1.0);
    }

    fn text(&mut self, at: (f64, f64), anchor: Anchor, colour: [u8; 3], text: &str) {
        self.texts.push((at, anchor, colour, text.into()));
    }
}
