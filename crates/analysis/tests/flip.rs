//! ꟻLIP compared with the implementation of its authors, `flip-evaluator` 1.7 from PyPI, which was run once on images
//! that are generated identically here.

mod common;

use common::{H, W, code};
use dapple_analysis::flip::{Map, PIXELS_PER_DEGREE, exposures, hdr, ldr};
use dapple_imaging::{Image, color};
use glam::Vec3;

fn picture(value: impl Fn(usize, usize, usize) -> f32) -> Image {
    let all = (0..H).flat_map(|y| (0..W).map(move |x| (x, y)));
    let pixels = all.map(|(x, y)| Vec3::from([0, 1, 2].map(|c| value(x, y, c)))).collect();
    Image { width: W, height: H, pixels }
}

fn display(k: usize) -> Image {
    picture(|x, y, c| color::srgb_table()[code(x, y, c, k) as usize])
}

/// The squared values, with a bright lamp.
fn radiance(k: usize) -> Image {
    picture(|x, y, c| {
        let v = f32::from(code(x, y, c, k)) / 64.0;
        if (10..14).contains(&y) && (20..26).contains(&x) { v * v * 64.0 } else { v * v }
    })
}

fn close(map: &Map, mean: f64, pixels: [(usize, usize, f32); 4]) {
    assert!((map.mean() - mean).abs() < 2e-5, "mean {} for {mean}", map.mean());
    for (x, y, value) in pixels {
        let found = map.values[y * W + x];
        assert!((found - value).abs() < 2e-4, "({x}, {y}): {found} for {value}");
    }
}

#[test]
fn display_pictures() {
    assert!((PIXELS_PER_DEGREE - 67.020_645).abs() < 1e-4);
    let found = ldr(&display(1), &display(0), PIXELS_PER_DEGREE).unwrap();
    let pixels = [(0, 0, 0.027_279_9), (24, 16, 0.184_210_5), (47, 31, 0.265_536_7), (30, 9, 0.072_932_8)];
    close(&found, 0.152_385_816, pixels);
    let found = ldr(&display(2), &display(0), PIXELS_PER_DEGREE).unwrap();
    let pixels = [(0, 0, 0.099_624_1), (24, 16, 0.084_573_1), (47, 31, 0.075_248_2), (30, 9, 0.093_249)];
    close(&found, 0.144_935_638, pixels);
}

#[test]
fn high_dynamic_range() {
    let reference = radiance(0);
    let chosen = exposures(&reference);
    assert!((chosen.start + 8.553_591).abs() < 1e-4 && (chosen.stop + 1.626_255).abs() < 1e-4, "{chosen:?}");
    assert_eq!(chosen.count, 7);
    let found = hdr(&radiance(1), &reference, PIXELS_PER_DEGREE).unwrap();
    let pixels = [(0, 0, 0.065_970_2), (24, 16, 0.190_221_4), (47, 31, 0.641_755), (22, 12, 0.235_427_3)];
    close(&found, 0.159_448_937, pixels);
    let found = hdr(&radiance(2), &reference, PIXELS_PER_DEGREE).unwrap();
    let pixels = [(0, 0, 0.246_735_5), (24, 16, 0.146_047_4), (47, 31, 0.326_008_8), (22, 12, 0.273_365_1)];
    close(&found, 0.159_394_1, pixels);
}

/// With a median of zero the series of exposures is long, as in the authors' implementation.
#[test]
fn a_mostly_black_reference() {
    let mut reference = radiance(0);
    reference.pixels[..20 * W].fill(Vec3::ZERO);
    let chosen = exposures(&reference);
    assert!((chosen.stop - 24.083_297).abs() < 1e-4, "{chosen:?}");
    let found = hdr(&radiance(1), &reference, PIXELS_PER_DEGREE).unwrap();
    assert!((found.mean() - 0.759_081_1).abs() < 2e-5, "{}", found.mean());
}

#[test]
fn extremes() {
    let plain = |v: Vec3| Image::filled(W, H, v);
    let mean = |a, b| ldr(&plain(a), &plain(b), PIXELS_PER_DEGREE).unwrap().mean();
    let black_and_white = mean(Vec3::ONE, Vec3::ZERO);
    // In f64 the formulas give 0.967 379 8; the authors' f32 implementation gives 0.967 399 1.
    assert!((black_and_white - 0.967_379_8).abs() < 2e-5, "{black_and_white}");
    assert!((mean(Vec3::Z, Vec3::Y) - 1.0).abs() < 1e-5);
    for v in [Vec3::ZERO, Vec3::ONE, Vec3::splat(1e-30), Vec3::splat(3e38)] {
        assert_eq!(mean(v, v), 0.0);
        assert_eq!(hdr(&plain(v), &plain(v), PIXELS_PER_DEGREE).unwrap().mean(), 0.0);
    }
    let mut spoiled = radiance(1);
    spoiled.pixels[5].x = f32::NAN;
    let found = hdr(&spoiled, &radiance(0), PIXELS_PER_DEGREE).unwrap();
    assert_eq!(found.values.iter().filter(|v| v.is_nan()).count(), 1);
    assert!(found.mean().is_finite());
}
