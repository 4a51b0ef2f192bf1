//! The colour spaces of ꟻLIP: linear Rec.709, the opponent space YCxCz, and L*a*b*, all for the white of D65.

// Constants as published.
#![allow(clippy::excessive_precision)]

use glam::{Mat3, Vec3};

/// Linear Rec.709 to CIE XYZ for the white (0.3127, 0.3290), column by column.
const TO_XYZ: Mat3 = Mat3::from_cols(
    Vec3::new(0.41238656, 0.21263682, 0.01933062),
    Vec3::new(0.35759149, 0.71518298, 0.11919716),
    Vec3::new(0.18045049, 0.07218020, 0.95037259),
);

/// The inverse of [`TO_XYZ`].
const FROM_XYZ: Mat3 = Mat3::from_cols(
    Vec3::new(3.24100323, -0.96922425, 0.05563942),
    Vec3::new(-1.53739897, 1.87592998, -0.20401121),
    Vec3::new(-0.49861588, 0.04155423, 1.05714898),
);

/// XYZ of white: the sum of the columns of [`TO_XYZ`].
const WHITE: Vec3 = Vec3::new(0.95042855, 1.00000000, 1.08890037);

/// Linear Rec.709 to the linearised L*a*b* space (Y, Cx, Cz) in which contrast sensitivity is measured [Andersson et
/// al. 2020, eq. 3].
pub(super) fn linear_to_opponent(rgb: Vec3) -> Vec3 {
    let v = TO_XYZ * rgb / WHITE;
    Vec3::new(116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z))
}

/// The inverse of [`linear_to_opponent`].
pub(super) fn opponent_to_linear(opponent: Vec3) -> Vec3 {
    let y = (opponent.x + 16.0) / 116.0;
    let v = Vec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0);
    FROM_XYZ * (v * WHITE)
}

/// L*a*b* of a linear colour with the Hunt adjustment, which reduces the chromaticity of dark colours [Andersson et al.
/// 2020, eq. 6].
pub(super) fn hunt_lab(rgb: Vec3) -> Vec3 {
    let v = (TO_XYZ * rgb / WHITE).map(lab_curve);
    let (l, a, b) = (116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z));
    Vec3::new(l, 0.01 * l * a, 0.01 * l * b)
}

/// The cube root, linear near zero.
fn lab_curve(t: f32) -> f32 {
    const DELTA: f32 = 6.0 / 29.0;
    if t > DELTA * DELTA * DELTA { libm::cbrtf(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

/// The HyAB distance: the lightness difference plus the Euclidean distance of the chromaticities.
pub(super) fn hyab(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    d.x.abs() + libm::sqrtf(d.y * d.y + d.z * d.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        assert!((TO_XYZ * FROM_XYZ).abs_diff_eq(Mat3::IDENTITY, 1e-6));
        assert!((TO_XYZ * Vec3::ONE).abs_diff_eq(WHITE, 1e-6));
        for rgb in [Vec3::ZERO, Vec3::ONE, Vec3::new(0.2, 0.9, 0.05)] {
            assert!(opponent_to_linear(linear_to_opponent(rgb)).abs_diff_eq(rgb, 2e-6), "{rgb}");
        }
        assert!(linear_to_opponent(Vec3::ONE).abs_diff_eq(Vec3::new(100.0, 0.0, 0.0), 1e-3));
    }
}
