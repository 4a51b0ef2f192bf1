//! Separable filters with repeated borders, and the filter of the eye's contrast sensitivity.

use glam::{Vec3, Vec4};
use std::f32::consts::PI;

/// The axis of a one-dimensional filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    /// Along a row.
    X,
    /// Along a column.
    Y,
}

/// Convolves each of four planes with its own kernel of 2r + 1 taps. Border pixels are repeated outside the image.
pub(super) fn convolve((w, h): (usize, usize), planes: &[Vec4], kernel: &[Vec4], axis: Axis) -> Vec<Vec4> {
    let reach = (kernel.len() / 2) as isize;
    let (length, stride) = match axis {
        Axis::X => (w, 1),
        Axis::Y => (h, w),
    };
    let one = |x: usize, y: usize| {
        let (along, base) = match axis {
            Axis::X => (x, y * w),
            Axis::Y => (y, x),
        };
        let tap = |i: usize| (along as isize + i as isize - reach).clamp(0, length as isize - 1) as usize;
        kernel.iter().enumerate().fold(Vec4::ZERO, |sum, (i, k)| sum + *k * planes[base + tap(i) * stride])
    };
    (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| one(x, y)).collect()
}

/// The contrast sensitivity of a channel as a spatial kernel: a sum of two Gaussians a √(π/b) exp(−π² x²/b), x in
/// degrees.
struct Sensitivity {
    a: [f32; 2],
    b: [f32; 2],
}

/// Achromatic, red–green, blue–yellow [Andersson et al. 2020, table 1].
const CHANNELS: [Sensitivity; 3] = [
    Sensitivity { a: [1.0, 0.0], b: [0.0047, 1e-5] },
    Sensitivity { a: [1.0, 0.0], b: [0.0053, 1e-5] },
    Sensitivity { a: [34.1, 13.5], b: [0.04, 0.025] },
];

/// Filters (Y, Cx, Cz) by the contrast sensitivity at `ppd` pixels per degree [Andersson et al. 2020, eq. 4 and 5].
pub(super) fn contrast_sensitivity(size: (usize, usize), opponent: &[Vec3], ppd: f32) -> Vec<Vec3> {
    // Four Gaussians, one per plane: the blue–yellow channel is the sum of two.
    let [achromatic, red_green, blue_yellow] = &CHANNELS;
    let width = [achromatic.b[0], red_green.b[0], blue_yellow.b[0], blue_yellow.b[1]];
    // Three standard deviations of the widest Gaussian.
    let reach = (3.0 * libm::sqrtf(0.04 / (2.0 * PI * PI)) * ppd).ceil() as i32;
    let taps = |b: f32| (-reach..=reach).map(move |i| libm::expf(-(PI * PI) * square(i as f32 / ppd) / b));
    let total = width.map(|b| taps(b).sum::<f32>());
    let mut kernel = vec![Vec4::ZERO; 2 * reach as usize + 1];
    for (plane, b) in width.into_iter().enumerate() {
        kernel.iter_mut().zip(taps(b)).for_each(|(k, t)| k[plane] = t / total[plane]);
    }
    // The share of each Gaussian in the two-dimensional sum of the blue–yellow kernel.
    let part = |i: usize| blue_yellow.a[i] * libm::sqrtf(PI / blue_yellow.b[i]) * square(total[2 + i]);
    let first = part(0) / (part(0) + part(1));
    let planes: Vec<Vec4> = opponent.iter().map(|v| v.extend(v.z)).collect();
    let blurred = convolve(size, &convolve(size, &planes, &kernel, Axis::X), &kernel, Axis::Y);
    blurred.iter().map(|v| Vec3::new(v.x, v.y, first * v.z + (1.0 - first) * v.w)).collect()
}

fn square(x: f32) -> f32 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_repeat_and_axes_differ() {
        let planes = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0].map(Vec4::splat);
        let kernel = [1.0, 0.0, -1.0].map(Vec4::splat);
        let along = |axis| convolve((3, 2), &planes, &kernel, axis).iter().map(|v| v.x).collect::<Vec<_>>();
        assert_eq!(along(Axis::X), [-1.0, -3.0, -2.0, -8.0, -24.0, -16.0]);
        assert_eq!(along(Axis::Y), [-7.0, -14.0, -28.0, -7.0, -14.0, -28.0]);
    }

    #[test]
    fn one_colour_stays_as_it_is() {
        let seen = contrast_sensitivity((5, 4), &[Vec3::new(3.0, -2.0, 40.0); 20], 67.0);
        assert!(seen.iter().all(|v| v.abs_diff_eq(Vec3::new(3.0, -2.0, 40.0), 1e-4)));
    }
}
