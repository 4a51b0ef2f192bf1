//! Structural similarity compared with closed forms and with scikit-image 0.26 from PyPI, which was run once on images
//! that are generated identically here (`structural_similarity` with `gaussian_weights`, standard deviation 1.5,
//! population covariance).

mod common;

use common::{H, W, code};
use dapple_analysis::ssim::ssim;
use dapple_imaging::{Image, color};
use glam::Vec3;

fn display(k: usize) -> Image {
    let pixel = |(x, y)| Vec3::from([0, 1, 2].map(|c| color::srgb_table()[code(x, y, c, k) as usize]));
    let pixels = (0..H).flat_map(|y| (0..W).map(move |x| (x, y))).map(pixel).collect();
    Image { width: W, height: H, pixels }
}

fn found(image: &Image, reference: &Image) -> f64 {
    ssim(image, reference).unwrap().unwrap()
}

#[test]
fn an_independent_implementation() {
    for (k, published) in [(1, 0.686_089_691_5), (2, 0.683_451_979_1)] {
        let found = found(&display(k), &display(0));
        // Both implementations evaluate the sRGB curve in f32.
        assert!((found - published).abs() < 2e-6, "{k}: {found}");
    }
}

#[test]
fn equal_pictures_are_1() {
    for picture in [display(0), display(1), Image::filled(W, H, Vec3::ZERO), Image::filled(11, 11, Vec3::X)] {
        assert_eq!(found(&picture, &picture), 1.0);
    }
    // Values above the display range make no difference.
    assert_eq!(found(&Image::filled(W, H, Vec3::ONE), &Image::filled(W, H, Vec3::splat(9.0))), 1.0);
}

/// Without structure only the means remain: (2ab + C₁)/(a² + b² + C₁) of the code values.
#[test]
fn plain_pictures() {
    for (a, b) in [(0.5, 0.25), (0.0, 1.0), (0.9, 0.8)] {
        let plain = |code: f32| Image::filled(W, H, Vec3::splat(color::srgb_to_linear(code)));
        let (a64, b64) = (f64::from(a), f64::from(b));
        let expected = (2.0 * a64 * b64 + 1e-4) / (a64 * a64 + b64 * b64 + 1e-4);
        let found = found(&plain(a), &plain(b));
        assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
    }
}

/// Stripes compared with inverted stripes: all variances are equal and the covariance is their negative. The means
/// hardly vary in a window as wide as this.
#[test]
fn a_negative_is_below_zero() {
    let stripes = |phase: usize| {
        let code = |i: usize| if (i + phase).is_multiple_of(2) { 0.7f32 } else { 0.3 };
        let pixels = (0..W * H).map(|i| Vec3::splat(color::srgb_to_linear(code(i)))).collect();
        Image { width: W, height: H, pixels }
    };
    let variance = 0.2f64 * 0.2;
    let expected = (9e-4 - 2.0 * variance) / (9e-4 + 2.0 * variance);
    let found = found(&stripes(0), &stripes(1));
    assert!((found - expected).abs() < 1e-3, "{found} for {expected}");
}

#[test]
fn windows_that_cannot_be_compared() {
    let small = Image::filled(10, 40, Vec3::ONE);
    assert_eq!(ssim(&small, &small).unwrap(), None);
    let low = Image::filled(40, 10, Vec3::ONE);
    assert_eq!(ssim(&low, &low).unwrap(), None);
    assert!(ssim(&small, &low).is_err());
    // All windows that contain a pixel that is not finite are excluded.
    let (mut spoiled, plain) = (display(1), display(0));
    spoiled.pixels.iter_mut().enumerate().filter(|(i, _)| i % W < 20).for_each(|(_, p)| p.y = f32::NAN);
    let cut = |p: &Image| {
        let kept = |(i, p): (usize, &Vec3)| (i % W >= 20).then_some(*p);
        Image { width: W - 20, height: H, pixels: p.pixels.iter().enumerate().filter_map(kept).collect() }
    };
    assert!((found(&spoiled, &plain) - found(&cut(&display(1)), &cut(&plain))).abs() < 1e-12);
    spoiled.pixels.fill(Vec3::NAN);
    assert_eq!(ssim(&spoiled, &plain).unwrap(), None);
}
