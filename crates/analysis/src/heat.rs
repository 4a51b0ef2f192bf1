//! Error maps: values as false colours.
//!
//! Magnitudes use matplotlib's magma in nine steps (dark is small). Signed values run from blue (negative) over near
//! black to red. NaN is green, which neither scale contains.

use dapple_imaging::Image;
use dapple_imaging::sheet::Frame;
use glam::Vec3;

/// Magma at 0, ⅛, … 1. *Approximation*: linear interpolation between the steps is at most three code values off.
const MAGMA: [[u8; 3]; 9] = [
    [0, 0, 4],
    [28, 16, 68],
    [79, 18, 123],
    [129, 37, 129],
    [181, 54, 122],
    [229, 80, 100],
    [251, 135, 97],
    [254, 194, 135],
    [252, 253, 191],
];

/// The scale of signed values, from −1 to 1.
const SIGNS: [[u8; 3]; 5] = [[120, 190, 255], [20, 90, 210], [16, 16, 16], [200, 60, 30], [255, 190, 110]];

/// The colour of NaN.
const NOT_A_NUMBER: [u8; 3] = [0, 220, 0];

/// Colour of a magnitude between 0 and 1; values outside are clipped.
pub fn magnitude(value: f64) -> [u8; 3] {
    along(&MAGMA, value)
}

/// Colour of a signed value between −1 and 1; values outside are clipped.
pub fn sign(value: f64) -> [u8; 3] {
    along(&SIGNS, 0.5 + 0.5 * value)
}

/// Maps `values` on a logarithmic scale from `low` (dark) to `high` (bright), row by row, `width` per row.
pub fn logarithmic(values: &[f64], width: usize, [low, high]: [f64; 2]) -> Frame {
    frame(values, width, |v| magnitude(libm::log(v.max(low) / low) / libm::log(high / low)))
}

/// Maps the root of each pixel's squared error relative to R² + 0.01, averaged over channels, on a logarithmic scale
/// from 0.001 to 1. Both images must have the same size.
pub fn relative(image: &Image, reference: &Image) -> Frame {
    let one = |(a, b): (&Vec3, &Vec3)| {
        let (d, r) = ((*a - *b).as_dvec3(), b.as_dvec3());
        (d * d / (r * r + 0.01)).element_sum() / 3.0
    };
    let values: Vec<f64> = image.pixels.iter().zip(&reference.pixels).map(|p| one(p).sqrt()).collect();
    logarithmic(&values, image.width, [1e-3, 1.0])
}

/// Maps `values` on a linear scale from 0 (dark) to 1 (bright), row by row.
pub fn linear(values: &[f64], width: usize) -> Frame {
    frame(values, width, magnitude)
}

/// Maps `values` from −`largest` (blue) over 0 (black) to `largest` (red), row by row.
pub fn signed(values: &[f64], width: usize, largest: f64) -> Frame {
    frame(values, width, |v| sign(v / largest))
}

fn frame(values: &[f64], width: usize, colour: impl Fn(f64) -> [u8; 3]) -> Frame {
    let data = values.iter().flat_map(|&v| if v.is_nan() { NOT_A_NUMBER } else { colour(v) }).collect();
    Frame { width, height: values.len() / width.max(1), data }
}

fn along(stops: &[[u8; 3]], value: f64) -> [u8; 3] {
    let value = if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
    let at = value * (stops.len() - 1) as f64;
    let i = (at as usize).min(stops.len() - 2);
    let mix = |c: usize| {
        let (a, b) = (f64::from(stops[i][c]), f64::from(stops[i + 1][c]));
        (a + (b - a) * (at - i as f64) + 0.5) as u8
    };
    [mix(0), mix(1), mix(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_where_they_should() {
        assert_eq!((magnitude(-1.0), magnitude(0.0), magnitude(0.5)), (MAGMA[0], MAGMA[0], MAGMA[4]));
        assert_eq!((magnitude(1.0), magnitude(f64::INFINITY)), (MAGMA[8], MAGMA[8]));
        assert_eq!((sign(-1.0), sign(0.0), sign(2.0)), (SIGNS[0], SIGNS[2], SIGNS[4]));
        let map = logarithmic(&[0.0, 1e-3, 1.0, f64::NAN, 1e-3f64.sqrt(), 9.0], 3, [1e-3, 1.0]);
        let expected = [MAGMA[0], MAGMA[0], MAGMA[8], NOT_A_NUMBER, MAGMA[4], MAGMA[8]];
        assert_eq!((map.width, map.height, map.data), (3, 2, expected.concat()));
    }
}
