//! Conversion between sRGB code values and linear light, and luminance.
//!
//! All colours inside dapple are linear Rec.709 RGB. Files of 8 or 16 bits contain sRGB code values, which have the
//! same primaries and a different transfer function [IEC 61966-2-1:1999, §5.2]. The curves here are the exact piecewise
//! ones, never a power of 2.2, and use `libm`, so that the results are bit-identical on every machine.

use glam::Vec3;
use std::sync::LazyLock;

/// Relative luminance Y of a linear Rec.709 colour [ITU-R BT.709-6, §3.3], in the unit of the colour.
pub fn luminance(rgb: Vec3) -> f32 {
    0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z
}

/// Decodes an sRGB code value to linear light. It is intended for [0, 1]; above, it continues as a power, and below as
/// a line through zero, so that the curve is monotone everywhere.
pub fn srgb_to_linear(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { libm::powf((c + 0.055) / 1.055, 2.4) }
}

/// Encodes linear light as an sRGB code value: the inverse of [`srgb_to_linear`]. Nothing is clipped.
pub fn linear_to_srgb(c: f32) -> f32 {
    if c <= 0.003_130_8 {
        return 12.92 * c;
    }
    // 1.055 p − 0.055, arranged so that white is exactly 1.
    let p = libm::powf(c, 1.0 / 2.4);
    p + 0.055 * (p - 1.0)
}

static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| decode_f64(i as f64 / 255.0)));
static UNIT: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| (i as f64 / 255.0) as f32));

/// Linear light of each 8-bit sRGB code value, computed in f64 and rounded once.
pub fn srgb_table() -> &'static [f32; 256] {
    &SRGB
}

/// i/255 for each 8-bit value i.
pub fn unit_table() -> &'static [f32; 256] {
    &UNIT
}

static SRGB_16: LazyLock<Box<[f32]>> =
    LazyLock::new(|| (0..=65_535).map(|i| decode_f64(f64::from(i) / 65_535.0)).collect());
static UNIT_16: LazyLock<Box<[f32]>> =
    LazyLock::new(|| (0..=65_535).map(|i| (f64::from(i) / 65_535.0) as f32).collect());

/// Linear light of each 16-bit sRGB code value, computed in f64 and rounded once.
pub(crate) fn srgb_table_16() -> &'static [f32] {
    &SRGB_16
}

/// i/65535 for each 16-bit value i.
pub(crate) fn unit_table_16() -> &'static [f32] {
    &UNIT_16
}

/// 1 for each 8-bit value: the table of a channel that is not stored.
pub(crate) fn ones_table() -> &'static [f32; 256] {
    &[1.0; 256]
}

/// The decoding curve in f64, for tables.
pub(crate) fn decode_f64(c: f64) -> f32 {
    (if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_inverse_and_monotone() {
        let mut last = -1.0;
        for i in 0..=10_000 {
            let c = i as f32 / 10_000.0;
            let linear = srgb_to_linear(c);
            assert!(linear > last, "not increasing at {c}");
            assert!((linear_to_srgb(linear) - c).abs() < 1e-6, "{c} came back as {}", linear_to_srgb(linear));
            last = linear;
        }
    }

    #[test]
    fn published_values() {
        // Mid grey: code value 0.5 is 0.21404 of white; 18 % grey has the code value 117.6/255.
        assert!((srgb_to_linear(0.5) - 0.214_041_1).abs() < 1e-6);
        assert!((linear_to_srgb(0.18) - 0.461_356_1).abs() < 1e-6);
        assert_eq!((srgb_to_linear(0.0), srgb_to_linear(1.0)), (0.0, 1.0));
        assert_eq!((linear_to_srgb(0.0), linear_to_srgb(1.0)), (0.0, 1.0));
        assert!((luminance(Vec3::ONE) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn tables_are_the_curves() {
        for i in 0..256 {
            let c = i as f32 / 255.0;
            assert!((srgb_table()[i] - srgb_to_linear(c)).abs() <= 2e-7, "{i}");
            assert_eq!(unit_table()[i], c);
        }
    }
}
