//! Structural similarity of two images.
//!
//! This is the mean structural similarity [Wang et al. 2004] of display luminance: the Rec.709 luminance of linear
//! light clipped to 0…1, encoded by the sRGB curve, so that the dynamic range L is 1. Local means, variances and the
//! covariance are weighted by a Gaussian of standard deviation 1.5 over 11×11 pixels, and the mean is taken over all
//! windows that lie entirely within the image. The result is 1 for equal images and smaller the less they have in
//! common; it is negative if one image is the negative of the other.

use crate::metrics::{SizeMismatch, same_size};
use dapple_imaging::{Image, color};
use glam::Vec3;

/// Pixels from the centre of a window to its edge.
const REACH: usize = 5;
/// Side of a window in pixels.
const SIDE: usize = 2 * REACH + 1;
/// Standard deviation of the weights in pixels.
const SIGMA: f64 = 1.5;
/// (K₁ L)² and (K₂ L)², which keep the ratios finite in dark and in uniform windows [Wang et al. 2004, §III.B].
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The mean structural similarity of the luminance of two images. `None` if no window of 11×11 pixels lies within the
/// images and is free of values that are not finite.
///
/// # Errors
/// The images differ in size.
pub fn ssim(image: &Image, reference: &Image) -> Result<Option<f64>, SizeMismatch> {
    same_size(image, reference)?;
    let (a, b) = (luminance(image), luminance(reference));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<_>>();
    let local = |values: &[f64]| weighted(values, image.width);
    let means = [local(&a), local(&b)];
    let squares = [local(&product(&a, &a)), local(&product(&b, &b)), local(&product(&a, &b))];
    let windows = (0..means[0].len())
        .map(|i| similarity(means.each_ref().map(|m| m[i]), squares.each_ref().map(|s| s[i])))
        .filter(|s| s.is_finite());
    let (sum, n) = windows.fold((0.0, 0.0), |(sum, n), s| (sum + s, n + 1.0));
    Ok((n > 0.0).then(|| sum / n))
}

/// The similarity of one window from the means of x, y, x², y² and xy [Wang et al. 2004, eq. 13].
fn similarity([x, y]: [f64; 2], [xx, yy, xy]: [f64; 3]) -> f64 {
    let (variances, covariance) = ((xx - x * x) + (yy - y * y), xy - x * y);
    (2.0 * x * y + C1) * (2.0 * covariance + C2) / ((x * x + y * y + C1) * (variances + C2))
}

/// Display luminance, 0 to 1; NaN where a pixel is not finite.
fn luminance(picture: &Image) -> Vec<f64> {
    let one = |p: &Vec3| match p.is_finite() {
        true => f64::from(color::linear_to_srgb(color::luminance(p.clamp(Vec3::ZERO, Vec3::ONE)))),
        false => f64::NAN,
    };
    picture.pixels.iter().map(one).collect()
}

/// The weighted mean of every window, row by row; filters rows first, then columns.
fn weighted(values: &[f64], width: usize) -> Vec<f64> {
    if width < SIDE {
        return Vec::new();
    }
    let weights = weights();
    let along =
        |values: &[f64]| values.windows(SIDE).map(|w| dot(w.iter().copied(), &weights)).collect::<Vec<_>>();
    let rows: Vec<Vec<f64>> = values.chunks_exact(width).map(along).collect();
    let down = |rows: &[Vec<f64>]| -> Vec<f64> {
        (0..rows[0].len()).map(|x| dot(rows.iter().map(|row| row[x]), &weights)).collect()
    };
    rows.windows(SIDE).flat_map(down).collect()
}

fn dot(values: impl Iterator<Item = f64>, weights: &[f64; SIDE]) -> f64 {
    values.zip(weights).map(|(v, w)| v * w).sum()
}

/// The weights of a Gaussian, normalised to a sum of 1.
fn weights() -> [f64; SIDE] {
    let bell = |i: usize| libm::exp(-0.5 * ((i as f64 - REACH as f64) / SIGMA).powi(2));
    let sum: f64 = (0..SIDE).map(bell).sum();
    std::array::from_fn(|i| bell(i) / sum)
}
