//! Error metrics of an image against a reference.
//!
//! All metrics are means over pixels and channels of linear radiance, in f64. A pixel that is not finite in either
//! image is excluded from every metric, counted, and reported. With I the image and R the reference:
//!
//! | measure | formula |
//! |---|---|
//! | MSE, RMSE | mean (I − R)², and its root |
//! | relative RMSE | RMSE / mean R |
//! | relMSE | mean (I − R)² / (R² + ε), R of the same channel of the same pixel |
//! | trimmed relMSE | relMSE without the largest share of its terms; it hides fireflies, so read it beside relMSE |
//! | bias | mean (I − R) |
//! | MAPE | mean \|I − R\| / (\|R\| + ε) |
//! | SMAPE | mean \|I − R\| / (\|I\| + \|R\| + ε) |
//! | PSNR | 10 log₁₀(peak² / MSE) in decibels, infinite for equal images |
//!
//! A rendered reference is noisy, and the plain MSE adds its variance to the error. [`compare_halves`] takes the
//! reference as two independent renders R₁, R₂ and uses (I − R₁)(I − R₂), whose expectation is (I − E R)². This
//! estimate is exactly unbiased and may therefore be negative if the error is small compared with the noise of the
//! reference. In every denominator R is then the mean of both halves, so that relMSE is the same measure for one
//! reference and for two halves of it. *Approximation*: the denominator of relMSE keeps the noise of R, an error of
//! second order: relMSE is too large by about 3 (1 + 2v/e²) v/R² where e² is the squared error of the image and v the
//! variance of R, both of the pixel (for R² ≫ ε): 1 % where a pixel of the reference is known to 5 % and the image is
//! much noisier.

mod measures;
mod sums;

pub use measures::{Measures, Scale};

use dapple_imaging::Image;
use sums::{Sums, Term};

/// The result of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Metrics over all pixels and channels.
    pub overall: Measures,
    /// Metrics of red, green and blue.
    pub channels: [Measures; 3],
    /// Number of pixels compared.
    pub pixels: usize,
    /// Number of pixels excluded because a channel of either image is not finite.
    pub nan_pixels: usize,
    /// Column and row of the first excluded pixel.
    pub nan_pixel: Option<[usize; 2]>,
}

/// Two images of different size cannot be compared pixel by pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the images differ in size: {}x{} and {}x{} pixels", .image.0, .image.1, .reference.0, .reference.1)]
pub struct SizeMismatch {
    /// Width and height of the image.
    pub image: (usize, usize),
    /// Width and height of the reference.
    pub reference: (usize, usize),
}

/// Checks that both images have the same size.
pub fn same_size(image: &Image, reference: &Image) -> Result<(), SizeMismatch> {
    let size = |p: &Image| (p.width, p.height);
    if size(image) == size(reference) {
        Ok(())
    } else {
        Err(SizeMismatch { image: size(image), reference: size(reference) })
    }
}

/// Compares `image` with a reference that is regarded as exact.
pub fn compare(image: &Image, reference: &Image, scale: &Scale) -> Result<Comparison, SizeMismatch> {
    same_size(image, reference)?;
    Ok(sum_up(image, [reference; 2], scale))
}

/// Compares `image` with a reference given as two independent renders of equal sample count. MSE and the metrics
/// derived from it are unbiased; bias, MAPE, SMAPE, the largest error and R in denominators use the mean of both
/// halves.
pub fn compare_halves(image: &Image, halves: [&Image; 2], scale: &Scale) -> Result<Comparison, SizeMismatch> {
    halves.iter().try_for_each(|half| same_size(image, half))?;
    Ok(sum_up(image, halves, scale))
}

/// The remaining MSE of the mean of two independent halves: ¼ mean (R₁ − R₂)², over finite pixels and all channels.
pub fn halves_mse(halves: [&Image; 2]) -> Result<f64, SizeMismatch> {
    same_size(halves[0], halves[1])?;
    let squares = halves[0].pixels.iter().zip(&halves[1].pixels).map(|(a, b)| (*a - *b).as_dvec3());
    let finite: Vec<f64> = squares.filter(|d| d.is_finite()).map(|d| d.length_squared() / 12.0).collect();
    Ok(finite.iter().sum::<f64>() / finite.len() as f64)
}

/// The mean of two images of equal size, pixel by pixel.
pub fn mean([a, b]: [&Image; 2]) -> Image {
    let pixels = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a + *b) * 0.5).collect();
    Image { width: a.width, height: a.height, pixels }
}

fn sum_up(image: &Image, halves: [&Image; 2], scale: &Scale) -> Comparison {
    let mut overall = Sums::default();
    let mut channels: [Sums; 3] = Default::default();
    let (mut nan_pixels, mut nan_pixel) = (0, None);
    let place = |i: usize| [i % image.width, i / image.width];
    for (i, &p) in image.pixels.iter().enumerate() {
        let (a, b) = (halves[0].pixels[i], halves[1].pixels[i]);
        if !(p.is_finite() && a.is_finite() && b.is_finite()) {
            nan_pixels += 1;
            nan_pixel = nan_pixel.or(Some(place(i)));
            continue;
        }
        for (c, channel) in channels.iter_mut().enumerate() {
            let term = Term::new(p[c], [a[c], b[c]], scale);
            channel.add(&term, i);
            overall.add(&term, i);
        }
    }
    let pixels = image.pixels.len() - nan_pixels;
    let finish = |sums: Sums| sums.finish(scale, place);
    Comparison { overall: finish(overall), channels: channels.map(finish), pixels, nan_pixels, nan_pixel }
}
