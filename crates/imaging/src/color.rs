//! The sRGB transfer function [IEC 61966-2-1] and luminance.

use glam::Vec3;
use std::sync::LazyLock;

/// Rec.709 luminance of a linear colour.
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.212_639, 0.715_168_7, 0.072_192_32))
}

/// Encoded value to linear light.
pub fn srgb_to_linear(c: f32) -> f32 {
    if c <= 0.040_45 { c / 12.92 } else { libm::powf((c + 0.055) / 1.055, 2.4) }
}

/// Linear light to encoded value.
pub fn linear_to_srgb(c: f32) -> f32 {
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * libm::powf(c, 1.0 / 2.4) - 0.055 }
}

/// [`srgb_to_linear`] of every byte.
pub static SRGB_BYTE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear(i as f32 / 255.0)));

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transfer_functions_are_inverse() {
        for i in 0..=1000 {
            let c = i as f32 / 1000.0;
            assert!((linear_to_srgb(srgb_to_linear(c)) - c).abs() < 2e-6);
        }
        assert!((srgb_to_linear(0.5) - 0.214_041_1).abs() < 1e-6);
        assert!((luminance(Vec3::ONE) - 1.0).abs() < 1e-6);
    }
}
