//! z-tests: agreement of two means, or of all tiles of two images, given their errors.
//!
//! Every test gives a two-sided p, the probability of a difference at least this large if the exact values are equal.
//! In a family of m tests that may raise a false alarm with probability `level`, each test has the level 1 − (1 −
//! level)^(1/m) [Šidák 1967].

use statrs::function::erf::erfc;
use std::fmt;

/// Returns the probability that a standard normal variable is farther from 0 than |z|. It is 0 for NaN.
pub fn two_sided(z: f64) -> f64 {
    if z.is_nan() { 0.0 } else { erfc(z.abs() * std::f64::consts::FRAC_1_SQRT_2) }
}

/// Returns the level of each of `tests` independent tests for a family level: 1 − (1 − level)^(1/tests).
pub fn sidak(level: f64, tests: usize) -> f64 {
    -((-level).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// A difference in units of its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Z {
    /// Difference divided by its standard error. Without error, it is 0 for equal values and infinite for different
    /// ones.
    pub z: f64,
    /// Two-sided p-value.
    pub p: f64,
}

impl Z {
    fn new(difference: f64, variance: f64) -> Self {
        let z = if difference == 0.0 { 0.0 } else { difference / variance.sqrt() };
        Self { z, p: two_sided(z) }
    }
}

/// Compares a measured mean and its standard error with an exact value.
pub fn exact(mean: f64, standard_error: f64, exact: f64) -> Z {
    Z::new(mean - exact, standard_error * standard_error)
}

/// Compares two measured means, each with its own standard error [Welch 1947, normal limit].
pub fn welch(mean_a: f64, standard_error_a: f64, mean_b: f64, standard_error_b: f64) -> Z {
    Z::new(mean_a - mean_b, standard_error_a * standard_error_a + standard_error_b * standard_error_b)
}

/// One channel of an image with its variances.
#[derive(Clone, Copy, Debug)]
pub struct Channel<'a> {
    /// Pixel means in row-major order.
    pub mean: &'a [f64],
    /// Variances *of those means* (variance of a sample over the number of samples); empty for an exact image.
    pub variance: &'a [f64],
}

/// One tile of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    /// Column of the upper left pixel.
    pub x: usize,
    /// Row of the upper left pixel.
    pub y: usize,
    /// Means of the two images.
    pub means: [f64; 2],
    /// Test of their difference.
    pub test: Z,
}

/// A comparison of two images by tiles.
#[derive(Clone, Debug)]
pub struct Tiles {
    /// All tiles in row-major order.
    pub tiles: Vec<Tile>,
    /// Test of the means of the whole images, which detects a bias too small to be detected in a tile.
    pub whole: Z,
    /// Level of each test, by Šidák over the tiles and the whole image.
    pub level: f64,
}

/// Compares two images of `width` columns by the means of `size`×`size` tiles with Welch's z and both variances, at
/// family level `level`. Pixels are assumed to be independent, so that it must not be used with filters that share
/// samples between pixels.
///
/// # Panics
/// Panics when the lengths do not match each other or the width.
pub fn tiles(a: Channel<'_>, b: Channel<'_>, width: usize, size: usize, level: f64) -> Tiles {
    let count = a.mean.len();
    assert!(
        width > 0 && size > 0 && count > 0 && count.is_multiple_of(width),
        "{count} pixels, width {width}"
    );
    assert_eq!(count, b.mean.len(), "images of different sizes");
    for channel in [a, b] {
        assert!(channel.variance.is_empty() || channel.variance.len() == count, "one variance per pixel");
    }
    let height = count / width;
    let tiles: Vec<Tile> = (0..height.div_ceil(size))
        .flat_map(|j| (0..width.div_ceil(size)).map(move |i| (i * size, j * size)))
        .map(|(x, y)| tile(a, b, width, [x, y], [(x + size).min(width), (y + size).min(height)]))
        .collect();
    let whole = tile(a, b, width, [0, 0], [width, height]).test;
    let level = sidak(level, tiles.len() + 1);
    Tiles { tiles, whole, level }
}

fn tile(a: Channel<'_>, b: Channel<'_>, width: usize, [x, y]: [usize; 2], [x1, y1]: [usize; 2]) -> Tile {
    let n = ((x1 - x) * (y1 - y)) as f64;
    let sum = |values: &[f64]| -> f64 {
        if values.is_empty() {
            0.0
        } else {
            (y..y1).flat_map(|j| &values[j * width + x..j * width + x1]).sum()
        }
    };
    let means = [sum(a.mean) / n, sum(b.mean) / n];
    let test = Z::new(means[0] - means[1], (sum(a.variance) + sum(b.variance)) / (n * n));
    Tile { x, y, means, test }
}

impl Tiles {
    /// Returns whether p is at or above the level for all tiles and for the whole image.
    pub fn passed(&self) -> bool {
        self.whole.p >= self.level && self.tiles.iter().all(|t| t.test.p >= self.level)
    }

    /// Returns the p of the hypothesis that the z of the tiles are standard normal [Kolmogorov–Smirnov]. It detects
    /// moderate errors in too many tiles, and wrong variances. It needs many samples per pixel and no tile without
    /// variance.
    pub fn normality(&self) -> f64 {
        let mut z: Vec<f64> = self.tiles.iter().map(|t| t.test.z).collect();
        normality(&mut z)
    }
}

/// Formats whether the test passed, the result for the whole image, and the worst tiles.
impl fmt::Display for Tiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let failed = self.tiles.iter().filter(|t| t.test.p < self.level).count();
        writeln!(
            f,
            "{}: {failed} of {} tiles below p = {:.2e}; whole image z = {:.2} (p = {:.2e})",
            if self.passed() { "pass" } else { "FAIL" },
            self.tiles.len(),
            self.level,
            self.whole.z,
            self.whole.p
        )?;
        let mut worst: Vec<&Tile> = self.tiles.iter().collect();
        worst.sort_by(|a, b| a.test.p.total_cmp(&b.test.p));
        for t in worst.iter().take(5) {
            let [a, b] = t.means;
            writeln!(
                f,
                "  ({}, {}): {a:.6e} versus {b:.6e}, z = {:.2}, p = {:.2e}",
                t.x, t.y, t.test.z, t.test.p
            )?;
        }
        Ok(())
    }
}

/// Returns the p of the hypothesis that the values are standard normal [Kolmogorov–Smirnov, Stephens' form], and sorts
/// the values.
pub fn normality(z: &mut [f64]) -> f64 {
    z.sort_by(f64::total_cmp);
    let n = z.len() as f64;
    let distance = z.iter().enumerate().fold(0.0, |d: f64, (i, &z)| {
        let cdf = 0.5 * erfc(-z * std::f64::consts::FRAC_1_SQRT_2);
        d.max(cdf - i as f64 / n).max((i + 1) as f64 / n - cdf)
    });
    let t = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * distance;
    if t < 0.2 {
        return 1.0;
    }
    let term = |k: i32| 2.0 * f64::from(1 - 2 * ((k + 1) % 2)) * (-2.0 * f64::from(k * k) * t * t).exp();
    (1..=100).map(term).sum::<f64>().clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rng;

    #[test]
    fn known_values() {
        assert!((two_sided(1.959_963_985) - 0.05).abs() < 1e-9);
        assert!((two_sided(-4.0) / 6.334e-5 - 1.0).abs() < 1e-3);
        assert_eq!(two_sided(f64::NAN), 0.0);
        assert!((sidak(0.05, 10) - 0.005_116_196_89).abs() < 1e-10);
        assert_eq!(exact(1.0, 0.0, 1.0).p, 1.0);
        assert_eq!(exact(1.0, 0.0, 1.1).p, 0.0);
        assert_eq!(exact(f64::NAN, 1.0, 1.0).p, 0.0);
        assert_eq!(welch(3.0, 3.0, -2.0, 4.0).z, 1.0);
    }

    /// An image of noise with its true variance, plus `bias` in its first tile and `drift` everywhere.
    fn noise(seed: u64, bias: f64, drift: f64) -> (Vec<f64>, Vec<f64>) {
        let mut rng = Rng::new(seed);
        let mean = (0..64 * 48).map(|i| {
            let local = if i % 64 < 8 && i / 64 < 8 { bias } else { 0.0 };
            5.0 + 0.1 * rng.normal() + local + drift
        });
        (mean.collect(), vec![0.01; 64 * 48])
    }

    fn compare(bias: f64, drift: f64) -> Tiles {
        let ((a, va), (b, vb)) = (noise(1, bias, drift), noise(2, 0.0, 0.0));
        tiles(Channel { mean: &a, variance: &va }, Channel { mean: &b, variance: &vb }, 64, 8, 1e-4)
    }

    #[test]
    fn tiles_pass_without_and_fail_with_a_difference() {
        let same = compare(0.0, 0.0);
        assert!(same.passed() && same.normality() > 1e-3, "{same}");
        assert_eq!(same.tiles.len(), 48);
        // One tile is off by 0.15, which is 8.5 of its standard errors and not detectable in the mean of the whole
        // image.
        let local = compare(0.15, 0.0);
        assert!(!local.passed() && local.whole.p > local.level, "{local}");
        // All tiles are off by 0.02, which is about one standard error of a tile and eight of the whole image.
        let global = compare(0.0, 0.02);
        assert!(
            !global.passed() && global.tiles.iter().filter(|t| t.test.p < global.level).count() < 5,
            "{global}"
        );
    }

    #[test]
    fn wrong_variances_are_not_normal() {
        let mut rng = Rng::new(3);
        let mut z: Vec<f64> = (0..2000).map(|_| rng.normal()).collect();
        assert!(normality(&mut z) > 1e-3);
        let mut wide: Vec<f64> = z.iter().map(|z| z * 1.25).collect();
        assert!(normality(&mut wide) < 1e-4);
    }

    #[test]
    fn exact_pictures_need_no_variance() {
        let a = [1.0, 2.0, 3.0, 4.0];
        let t = tiles(Channel { mean: &a, variance: &[] }, Channel { mean: &a, variance: &[] }, 2, 1, 1e-4);
        assert!(t.passed());
    }
}
