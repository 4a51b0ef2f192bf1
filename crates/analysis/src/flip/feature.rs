//! The feature difference of ꟻLIP: differences of edges and points, which attract the eye.

use super::filter::{Axis, convolve};
use glam::{Vec2, Vec3, Vec4};

/// Width w of the detected features in degrees.
const WIDTH: f32 = 0.082;

/// The feature difference per pixel, 0 to 1: the root (q_f = ½) of the larger of the edge and the point difference
/// [Andersson et al. 2020, eq. 13 and 14].
pub(super) fn difference(size: (usize, usize), a: &[Vec3], b: &[Vec3], ppd: f32) -> Vec<f32> {
    let detect = |p: &[Vec3]| strengths(size, p, ppd);
    let larger = |(a, b): (Vec2, Vec2)| (a - b).abs().max_element();
    let scaled = |d: f32| libm::sqrtf(d * std::f32::consts::FRAC_1_SQRT_2);
    detect(a).into_iter().zip(detect(b)).map(larger).map(scaled).collect()
}

/// Magnitudes of the edge and of the point detector in the achromatic channel.
fn strengths(size: (usize, usize), opponent: &[Vec3], ppd: f32) -> Vec<Vec2> {
    let [smooth, edge, point] = kernels(0.5 * WIDTH * ppd);
    let lanes = |a: &[f32], b: &[f32], c: &[f32], d: &[f32]| -> Vec<Vec4> {
        (0..a.len()).map(|i| Vec4::new(a[i], b[i], c[i], d[i])).collect()
    };
    let light: Vec<Vec4> = opponent.iter().map(|v| Vec4::splat((v.x + 16.0) / 116.0)).collect();
    let across = convolve(size, &light, &lanes(&edge, &point, &smooth, &smooth), Axis::X);
    let both = convolve(size, &across, &lanes(&smooth, &smooth, &edge, &point), Axis::Y);
    both.iter().map(|v| Vec2::new(Vec2::new(v.x, v.z).length(), Vec2::new(v.y, v.w).length())).collect()
}

/// A Gaussian of standard deviation `sigma` pixels and its first and second derivatives; the positive taps sum to 1,
/// the negative ones to −1.
fn kernels(sigma: f32) -> [Vec<f32>; 3] {
    let reach = (3.0 * sigma).ceil() as i32;
    let gaussian = |x: f32| libm::expf(-x * x / (2.0 * sigma * sigma));
    let taps = |f: &dyn Fn(f32) -> f32| (-reach..=reach).map(|i| f(i as f32)).collect::<Vec<_>>();
    [
        normalised(taps(&gaussian)),
        normalised(taps(&|x| -x * gaussian(x))),
        normalised(taps(&|x| (x * x / (sigma * sigma) - 1.0) * gaussian(x))),
    ]
}

fn normalised(taps: Vec<f32>) -> Vec<f32> {
    let sum = |sign: f32| taps.iter().map(|t| (t * sign).max(0.0)).sum::<f32>();
    let (positive, negative) = (sum(1.0), sum(-1.0));
    taps.iter()
        .map(|&t| {
            if t > 0.0 {
                t / positive
            } else if t < 0.0 {
                t / negative
            } else {
                0.0
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_edge_has_strength_one() {
        let step: Vec<Vec3> = (0..40).map(|i| Vec3::X * if i % 20 < 10 { -16.0 } else { 100.0 }).collect();
        let found = strengths((20, 2), &step, 67.0);
        assert!(found.iter().map(|v| v.x).fold(0.0, f32::max) > 0.8);
        assert!(strengths((20, 2), &[Vec3::X * 50.0; 40], 67.0).iter().all(|v| v.length() < 1e-5));
    }
}
