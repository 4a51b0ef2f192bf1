//! Film: the mean and variance of the samples of every pixel, accumulated in f64.
//!
//! The estimate of a pixel is (1/N) Σ value·weight with N the number of samples (not the sum of weights), which is
//! unbiased for filters whose weights have mean 1. Pixels are addressed in coordinates of the full image.
use dapple_math::{Image, PixelRect};
use glam::{DVec3, Vec3};
use std::fmt;

/// Running mean and sum of squared deviations of one pixel, per channel (Welford's recurrence).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Pixel {
    n: u64,
    mean: DVec3,
    m2: DVec3,
}
impl Pixel {
    /// Updates mean += δ/n and m2 += δ·(x − mean), and returns the increase of m2 summed over channels. It is exact for
    /// constants at any n. [Welford 1962]
    #[inline]
    fn add(&mut self, x: DVec3) -> f64 {
        self.n += 1;
        let delta = x - self.mean;
        self.mean += delta * (1.0 / self.n as f64);
        let more = delta * (x - self.mean);
        self.m2 += more;
        more.element_sum()
    }
    /// Combines two disjoint sets of samples. [Chan 1979]
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
    /// Returns m2/(n(n − 1)). It is infinite, meaning unknown, while n < 2.
    fn variance_of_mean(&self) -> Vec3 {
        if self.n < 2 {
            return Vec3::INFINITY;
        }
        let n = self.n as f64;
        (self.m2.max(DVec3::ZERO) / n / (n - 1.0)).as_vec3()
    }
}

/// A rectangle of pixels with the count, mean and variance of the samples of each. It takes 56 bytes per pixel.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Film {
    rect: PixelRect,
    pixels: Vec<Pixel>,
}

impl Film {
    /// Creates an empty film, in which all counts are zero.
    pub fn new(rect: PixelRect) -> Self {
        Self { rect, pixels: vec![Pixel::default(); rect.area()] }
    }

    /// Whether the film has as many pixels as its rectangle; a film that was read from a file may not.
    pub fn is_whole(&self) -> bool {
        self.pixels.len() == self.rect.area()
    }

    /// Returns the rectangle of pixels that the film covers.
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    #[inline]
    fn index(&self, x: u32, y: u32) -> Option<usize> {
        let inside = self.rect.contains(x, y);
        inside.then(|| (y - self.rect.y0) as usize * self.rect.width() as usize + (x - self.rect.x0) as usize)
    }

    /// Adds one sample and returns whether it is finite. A non-finite sample is counted with value zero.
    /// `x, y` are coordinates in the full image; a sample of a pixel that the film does not cover is ignored.
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, value: Vec3, weight: f32) -> bool {
        self.add_measured(x, y, value, weight).0
    }

    /// Like [`Film::add`]; also returns the increase of the pixel's sum of squared deviations, summed over channels.
    #[inline]
    pub fn add_measured(&mut self, x: u32, y: u32, value: Vec3, weight: f32) -> (bool, f64) {
        let value = value.as_dvec3() * weight as f64;
        let finite = value.is_finite();
        let grown = self.index(x, y).map(|i| self.pixels[i].add(if finite { value } else { DVec3::ZERO }));
        (finite, grown.unwrap_or_default())
    }

    /// Replaces pixels of this film by those of a tile. Pixels of the tile outside this film are ignored.
    pub fn put(&mut self, tile: &Film) {
        let both = self.rect.intersection(&tile.rect);
        let width = both.width() as usize;
        for y in both.y0..both.y1 {
            if let (Some(to), Some(from)) = (self.index(both.x0, y), tile.index(both.x0, y)) {
                self.pixels[to..to + width].copy_from_slice(&tile.pixels[from..from + width]);
            }
        }
    }

    /// Adds the samples of `other`, which must be independent of those of `self` and cover the same rectangle, and
    /// fails if the rectangles differ. The result is that of one film with all samples, up to rounding in f64: it is
    /// commutative and associative to about 1e-15 of the mean, but not to the last bit.
    pub fn merge(&mut self, other: &Film) -> Result<(), RectMismatch> {
        if self.rect != other.rect {
            return Err(RectMismatch { ours: self.rect, theirs: other.rect });
        }
        self.pixels.iter_mut().zip(&other.pixels).for_each(|(a, b)| a.merge(b));
        Ok(())
    }

    /// Returns the estimate (1/N) Σ value·weight of every pixel. Pixels without samples are black.
    pub fn mean(&self) -> Image {
        self.image(|p| p.mean.as_vec3())
    }

    /// Returns the variance of the mean per channel, Σ(x − mean)²/(n(n − 1)). It is infinite where n < 2. It is an
    /// estimate for independent samples; for stratified and Sobol points, whose error is smaller, it is too large.
    pub fn variance(&self) -> Image {
        self.image(Pixel::variance_of_mean)
    }

    /// Returns the number of samples of one pixel; 0 outside of the film.
    pub fn count(&self, x: u32, y: u32) -> u64 {
        self.index(x, y).map_or(0, |i| self.pixels[i].n)
    }

    /// Returns the number of samples of all pixels.
    pub fn samples(&self) -> u64 {
        self.pixels.iter().map(|p| p.n).sum()
    }

    /// Returns the mean of one pixel in f64; zero outside of the film.
    pub fn mean_at(&self, x: u32, y: u32) -> DVec3 {
        self.index(x, y).map_or(DVec3::ZERO, |i| self.pixels[i].mean)
    }

    fn image(&self, f: impl Fn(&Pixel) -> Vec3) -> Image {
        Image {
            width: self.rect.width() as usize,
            height: self.rect.height() as usize,
            pixels: self.pixels.iter().map(f).collect(),
        }
    }
}

/// The error of merging two films over different rectangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RectMismatch {
    /// Rectangle of the film that is merged into.
    pub ours: PixelRect,
    /// Rectangle of the film that is merged from.
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
        let i = 4 + 1; // row 1, column 1 of a film that is four pixels wide
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
