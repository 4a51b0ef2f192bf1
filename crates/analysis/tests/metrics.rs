//! Error metrics compared with values computed by hand, and the effect of a noisy reference.

use dapple_analysis::metrics::{Scale, compare, compare_halves, halves_mse};
use dapple_imaging::Image;
use dapple_testkit::Rng;
use glam::Vec3;

fn picture(width: usize, pixels: &[[f32; 3]]) -> Image {
    let pixels: Vec<Vec3> = pixels.iter().map(|p| Vec3::from(*p)).collect();
    Image { width, height: pixels.len() / width, pixels }
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-14 * b.abs().max(1.0)
}

/// 2×2 pixels with values that f32 represents exactly: R = (1, ½, 0, 4), errors (+½, −¼, +¼, +2) in red, 0 in green and
/// +1 in the first pixel of blue, where R = 0.
fn pair() -> (Image, Image) {
    let reference = picture(2, &[[1.0, 1.0, 0.0], [0.5, 1.0, 0.0], [0.0, 1.0, 0.0], [4.0, 1.0, 0.0]]);
    let image = picture(2, &[[1.5, 1.0, 1.0], [0.25, 1.0, 0.0], [0.25, 1.0, 0.0], [6.0, 1.0, 0.0]]);
    (image, reference)
}

#[test]
fn all_measures_by_hand() {
    let (image, reference) = pair();
    let scale = Scale { epsilon: 0.25, trim: 0.3, peak: 2.0 };
    let found = compare(&image, &reference, &scale).unwrap();
    let red = found.channels[0];
    // ¼, 1⁄16, 1⁄16, 4.
    assert!(close(red.mse, 4.375 / 4.0));
    assert!(close(red.rmse, (4.375f64 / 4.0).sqrt()));
    assert!(close(red.relative_rmse, (4.375f64 / 4.0).sqrt() / (5.5 / 4.0)));
    // Divided by 1.25, 0.5, 0.25, 16.25.
    let relative = [0.25 / 1.25, 0.125, 0.25, 4.0 / 16.25];
    assert!(close(red.relmse, relative.iter().sum::<f64>() / 4.0));
    assert!(close(red.relmse_trimmed, (relative.iter().sum::<f64>() - 0.25) / 3.0));
    assert!(close(red.bias, 2.5 / 4.0));
    assert!(close(red.mape, (0.5 / 1.25 + 0.25 / 0.75 + 0.25 / 0.25 + 2.0 / 4.25) / 4.0));
    assert!(close(red.smape, (0.5 / 2.75 + 0.25 / 1.0 + 0.25 / 0.5 + 2.0 / 10.25) / 4.0));
    assert!(close(red.psnr, 10.0 * (4.0f64 / (4.375 / 4.0)).log10()));
    assert_eq!((red.max_error, red.max_error_pixel), (2.0, Some([1, 1])));
    let green = found.channels[1];
    assert_eq!((green.mse, green.bias, green.max_error, green.psnr), (0.0, 0.0, 0.0, f64::INFINITY));
    assert!(close(found.channels[2].relmse, 1.0 / 0.25 / 4.0));
    assert!(close(found.overall.mse, (4.375 + 1.0) / 12.0));
    assert!(close(found.overall.bias, 3.5 / 12.0));
    assert_eq!((found.overall.max_error, found.overall.max_error_pixel), (2.0, Some([1, 1])));
    assert_eq!((found.pixels, found.nan_pixels), (4, 0));
}

#[test]
fn pixels_that_are_not_finite_are_counted_and_left_out() {
    let (mut image, mut reference) = pair();
    image.pixels[3].y = f32::NAN;
    reference.pixels[2].z = f32::NEG_INFINITY;
    let found = compare(&image, &reference, &Scale::default()).unwrap();
    assert_eq!((found.pixels, found.nan_pixels, found.nan_pixel), (2, 2, Some([0, 1])));
    assert!(close(found.overall.mse, (0.25 + 0.0625 + 1.0) / 6.0));
    assert_eq!(found.overall.max_error_pixel, Some([0, 0]));
    let nothing = picture(1, &[[f32::NAN; 3]]);
    let found = compare(&nothing, &nothing, &Scale::default()).unwrap();
    assert_eq!((found.pixels, found.nan_pixels, found.overall.max_error_pixel), (0, 1, None));
    assert!(found.overall.mse.is_nan() && found.overall.relmse.is_nan() && found.overall.psnr.is_nan());
}

#[test]
fn pictures_of_different_size_are_refused() {
    let (image, _) = pair();
    let other = picture(4, &[[0.0; 3]; 4]);
    let said = compare(&image, &other, &Scale::default()).unwrap_err().to_string();
    assert!(said.contains("2x2") && said.contains("4x1"), "{said}");
    assert!(compare_halves(&image, [&image, &other], &Scale::default()).is_err());
}

const SIDE: usize = 128;

fn level(i: usize) -> f32 {
    0.5 + (i % SIDE) as f32 / SIDE as f32
}

fn noisy(sigma: f64, rng: &mut Rng) -> Image {
    let one =
        |i: usize, rng: &mut Rng| Vec3::from([0; 3].map(|_: i32| level(i) + (sigma * rng.normal()) as f32));
    Image { width: SIDE, height: SIDE, pixels: (0..SIDE * SIDE).map(|i| one(i, rng)).collect() }
}

/// The reference of two halves is as noisy as the image: the plain MSE is twice the true value, the product of the
/// halves is correct.
#[test]
fn two_halves_take_the_noise_of_the_reference_out() {
    const SIGMA: f64 = 0.1;
    let mut rng = Rng::new(7);
    let mse = SIGMA * SIGMA;
    let image = noisy(SIGMA, &mut rng);
    let halves = [0; 2].map(|_| noisy(SIGMA * std::f64::consts::SQRT_2, &mut rng));
    let halves = [&halves[0], &halves[1]];
    let reference = dapple_analysis::metrics::mean(halves);
    let n = (SIDE * SIDE * 3) as f64;
    let plain = compare(&image, &reference, &Scale::default()).unwrap().overall;
    // The square of a normal variable of variance v has variance 2 v².
    assert!((plain.mse - 2.0 * mse).abs() < 4.0 * 2.0 * mse * (2.0 / n).sqrt(), "{}", plain.mse);
    let fair = compare_halves(&image, halves, &Scale::default()).unwrap().overall;
    // Var (e − a)(e − b) with variances 1, 2, 2: 2·1 + 1·2 + 1·2 + 2·2 = 10.
    assert!((fair.mse - mse).abs() < 4.0 * mse * (10.0 / n).sqrt(), "{}", fair.mse);
    let left = halves_mse(halves).unwrap();
    assert!((left - mse).abs() < 4.0 * mse * (2.0 / n).sqrt(), "{left}");
}

/// relMSE is mean (I − R)²/(R² + ε), with R of the same pixel, whether the reference is one exact image, a noisy one or
/// two halves. Bright and dark pixels alternate, so that an average over the neighbourhood would give another value.
#[test]
fn relmse_is_one_measure() {
    const NOISE: f64 = 0.1;
    const REFERENCE: f64 = 0.01;
    let truth = |i: usize| if (i % SIDE + i / SIDE).is_multiple_of(2) { 0.1 } else { 10.0 };
    let mut rng = Rng::new(11);
    let mut drawn = |noise: f64| {
        let one = |i: usize, rng: &mut Rng| {
            Vec3::from([0; 3].map(|_: i32| (truth(i) * (1.0 + noise * rng.normal())) as f32))
        };
        Image { width: SIDE, height: SIDE, pixels: (0..SIDE * SIDE).map(|i| one(i, &mut rng)).collect() }
    };
    let (exact, image) = (drawn(0.0), drawn(NOISE));
    let halves = [0; 2].map(|_| drawn(REFERENCE));
    let scale = Scale::default();
    let of = |r: f64| 0.5 * (NOISE * r) * (NOISE * r) / (r * r + scale.epsilon);
    let expected = of(0.1) + of(10.0);
    // The standard deviation of the square of a normal variable is √2 of its mean; the two kinds of pixels have 2/3 and
    // 1/3 of the sum.
    let deviation = expected * (2.0 * (4.0 + 1.0) / 9.0 * 2.0 / (3 * SIDE * SIDE) as f64).sqrt();
    let single = compare(&image, &exact, &scale).unwrap().overall.relmse;
    assert!((single - expected).abs() < 4.0 * deviation, "{single} for {expected}");
    let fair = compare_halves(&image, [&halves[0], &halves[1]], &scale).unwrap().overall.relmse;
    // Two equal halves give the same bits as one exact reference; a noisy reference adds its noise to each term.
    assert_eq!(compare_halves(&image, [&exact, &exact], &scale).unwrap().overall.relmse, single);
    assert!((fair - single).abs() < 0.01 * single, "{fair} for {single}");
    let noisy = compare(&image, &halves[0], &scale).unwrap().overall.relmse;
    let share = (REFERENCE / NOISE) * (REFERENCE / NOISE);
    assert!((noisy - single * (1.0 + share)).abs() < 0.01 * single, "{noisy} for {single}");
}

/// With halves whose noise is a quarter of the standard deviation of the image, relMSE is free of their noise to 3 %.
#[test]
fn relmse_is_free_of_the_noise_of_halves() {
    const SIGMA: f64 = 0.1;
    let mut rng = Rng::new(8);
    let image = noisy(SIGMA, &mut rng);
    let halves = [0; 2].map(|_| noisy(0.25 * SIGMA * std::f64::consts::SQRT_2, &mut rng));
    let fair = compare_halves(&image, [&halves[0], &halves[1]], &Scale::default()).unwrap().overall.relmse;
    let levels = (0..SIDE).map(|x| f64::from(level(x)));
    let truth = levels.map(|r| SIGMA * SIGMA / (r * r + 0.01)).sum::<f64>() / SIDE as f64;
    assert!((fair - truth).abs() < 0.03 * truth, "{fair} for {truth}");
}
