//! Sums of samples in f64: what is the mean of a pixel, and how sure is it?
//!
//! The estimate of a pixel is (1/N) Σ value·weight with N the number of samples (not the sum of weights), which is
//! unbiased for filters whose weights have mean 1. Pixels are addressed in coordinates of the full picture.
use dapple_math::{Image, PixelRect};
use glam::{DVec3, Vec3};
use std::fmt;

/// Running mean and sum of squared deviations of one pixel, per channel (Welford's recurrence).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Pixel {
    n: u64,
    mean: DVec3,
    m2: DVec3,
}
impl Pixel {
    /// mean += δ/n, m2 += δ·(x − mean); returns what m2 grows by, summed over channels. Exact for constants at any n.
    /// [Welford 1962]
    #[inline]
    fn add(&mut self, x: DVec3) -> f64 {
        self.n += 1;
        let delta = x - self.mean;
        self.mean += delta * (1.0 / self.n as f64);
        let more = delta * (x - self.mean);
        self.m2 += more;
        more.element_sum()
    }
    /// Union of two disjoint sample sets. [Chan 1979]
    fn merge(&mut self, other: &Self) {
        let n = self.n + other.n;
        if other.n == 0 {
            return;
        }
        let delta = other.mean - self.mean;
        let share = other.n as f64 / n as f64;
        self.mean += delta * share;
        self.m2 += other.m2 + delta * delta * (self.n as f64 * share);
        self.n = n;
    }
    /// m2/(n(n − 1)); infinite while n < 2, when nothing is known about it.
    fn variance_of_mean(&self) -> Vec3 {
        if self.n < 2 {
            return Vec3::INFINITY;
        }
        let n = self.n as f64;
        (self.m2.max(DVec3::ZERO) / n / (n - 1.0)).as_vec3()
    }
}

/// A rectangle of pixels with count, mean and variance each. 56 bytes per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    rect: PixelRect,
    pixels: Vec<Pixel>,
}

impl Film {
    /// An empty film: all counts zero.
    pub fn new(rect: PixelRect) -> Self {
        Self { rect, pixels: vec![Pixel::default(); rect.area()] }
    }

    /// The pixels it covers.
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    #[inline]
    fn index(&self, x: u32, y: u32) -> Option<usize> {
        let inside = self.rect.contains(x, y);
        inside.then(|| (y - self.rect.y0) as usize * self.rect.width() as usize + (x - self.rect.x0) as usize)
    }

    /// Adds one sample; a non-finite one adds zero, still counts, and returns false.
    /// `x, y` in the full picture; a pixel that the film does not cover is left alone.
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, value: Vec3, weight: f32) -> bool {
        self.add_measured(x, y, value, weight).0
    }

    /// As [`Film::add`]; also returns by how much the pixel's sum of squared deviations grew, all channels together.
    #[inline]
    pub fn add_measured(&mut self, x: u32, y: u32, value: Vec3, weight: f32) -> (bool, f64) {
        let value = value.as_dvec3() * weight as f64;
        let finite = value.is_finite();
        let grown = self.index(x, y).map(|i| self.pixels[i].add(if finite { value } else { DVec3::ZERO }));
        (finite, grown.unwrap_or_default())
    }

    /// Copies the pixels of a tile in, replacing what was there; pixels outside this film are dropped.
    pub fn put(&mut self, tile: &Film) {
        let both = self.rect.intersection(&tile.rect);
        let width = both.width() as usize;
        for y in both.y0..both.y1 {
            if let (Some(to), Some(from)) = (self.index(both.x0, y), tile.index(both.x0, y)) {
                self.pixels[to..to + width].copy_from_slice(&tile.pixels[from..from + width]);
            }
        }
    }

    /// Joins the samples of `other`, taken independently of these, over the same rectangle. The result is that of one
    /// film given all samples, up to f64 rounding: commutative and associative to about 1e-15 of the mean, not to the bit.
    pub fn merge(&mut self, other: &Film) -> Result<(), RectMismatch> {
        if self.rect != other.rect {
            return Err(RectMismatch { ours: self.rect, theirs: other.rect });
        }
        self.pixels.iter_mut().zip(&other.pixels).for_each(|(a, b)| a.merge(b));
        Ok(())
    }

    /// The estimate: (1/N) Σ value·weight; black where nothing was sampled.
    pub fn mean(&self) -> Image {
        self.picture(|p| p.mean.as_vec3())
    }

    /// Variance of the mean, per channel: Σ(x − mean)²/(n(n − 1)). Infinite where n < 2. An estimate for independent
    /// samples; for stratified and Sobol points it is too large (their error is smaller than it says).
    pub fn variance(&self) -> Image {
        self.picture(Pixel::variance_of_mean)
    }

    /// Samples added to one pixel; 0 outside.
    pub fn count(&self, x: u32, y: u32) -> u64 {
        self.index(x, y).map_or(0, |i| self.pixels[i].n)
    }

    /// Samples added to all pixels.
    pub fn samples(&self) -> u64 {
        self.pixels.iter().map(|p| p.n).sum()
    }

    /// The mean of one pixel in f64; zero outside.
    pub fn mean_at(&self, x: u32, y: u32) -> DVec3 {
        self.index(x, y).map_or(DVec3::ZERO, |i| self.pixels[i].mean)
    }

    fn picture(&self, f: impl Fn(&Pixel) -> Vec3) -> Image {
        Image {
            width: self.rect.width() as usize,
            height: self.rect.height() as usize,
            pixels: self.pixels.iter().map(f).collect(),
        }
    }
}

/// Two films over different rectangles cannot be merged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RectMismatch {
    /// The film merged into.
    pub ours: PixelRect,
    /// The film merged from.
    pub theirs: PixelRect,
}
impl fmt::Display for RectMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let show = |r: PixelRect| format!("{},{},{},{}", r.x0, r.y0, r.x1, r.y1);
        write!(f, "cannot merge films of pixels {} and {}", show(self.ours), show(self.theirs))
    }
}
impl std::error::Error for RectMismatch {}

#[cfg(test)]
mod tests {
    use super::*;

    const RECT: PixelRect = PixelRect { x0: 3, y0: 5, x1: 7, y1: 8 };

    #[test]
    fn mean_and_variance_of_a_few_numbers() {
        let mut film = Film::new(RECT);
        for x in [1.0, 2.0, 3.0, 4.0] {
            assert!(film.add(4, 6, Vec3::splat(x), 1.0));
        }
        let i = 4 + 1; // row 1, column 1 of a film four wide
        assert_eq!(film.mean().pixels[i], Vec3::splat(2.5));
        assert!((film.variance().pixels[i].x - 5.0 / 12.0).abs() < 1e-7);
        assert_eq!(film.variance().pixels[0], Vec3::INFINITY);
        assert_eq!((film.count(4, 6), film.count(3, 5), film.count(99, 99)), (4, 0, 0));
        assert_eq!(film.samples(), 4);
    }

    #[test]
    fn a_bad_sample_counts_as_zero_and_is_told() {
        let mut film = Film::new(RECT);
        assert!(film.add(3, 5, Vec3::ONE, 1.0));
        for bad in [Vec3::NAN, Vec3::new(0.0, f32::INFINITY, 0.0)] {
            assert!(!film.add(3, 5, bad, 1.0));
        }
        assert!(!film.add(3, 5, Vec3::ONE, f32::NAN));
        assert_eq!(film.count(3, 5), 4);
        assert_eq!(film.mean().pixels[0], Vec3::splat(0.25));
    }

    #[test]
    fn tiles_go_where_they_belong() {
        let mut film = Film::new(RECT);
        let mut tile = Film::new(PixelRect { x0: 5, y0: 6, x1: 9, y1: 9 });
        tile.add(6, 7, Vec3::X, 1.0);
        tile.add(8, 8, Vec3::Y, 1.0);
        film.put(&tile);
        assert_eq!(film.mean_at(6, 7), DVec3::X);
        assert_eq!(film.mean().pixels.iter().filter(|p| **p != Vec3::ZERO).count(), 1);
        film.put(&Film::new(PixelRect { x0: 100, y0: 0, x1: 101, y1: 1 }));
    }

    #[test]
    fn merged_halves_equal_the_whole() {
        let (mut a, mut b, mut all) = (Film::new(RECT), Film::new(RECT), Film::new(RECT));
        for i in 0..1000u32 {
            let v = Vec3::new(i as f32, 1e6 + (i % 7) as f32, 1.0 / (1.0 + i as f32));
            let half = if i % 3 == 0 { &mut a } else { &mut b };
            half.add(3, 5, v, 1.0);
            all.add(3, 5, v, 1.0);
        }
        a.merge(&b).unwrap();
        assert_eq!(a.count(3, 5), 1000);
        let error = ((a.mean_at(3, 5) - all.mean_at(3, 5)) / all.mean_at(3, 5)).abs().max_element();
        assert!(error < 1e-14, "{error}");
        let ratio = a.variance().pixels[0] / all.variance().pixels[0];
        assert!((ratio - Vec3::ONE).abs().max_element() < 1e-6, "{ratio}");
        let other = Film::new(PixelRect { x0: 0, ..RECT });
        assert_eq!(a.merge(&other).unwrap_err().theirs, other.rect());
    }
}
