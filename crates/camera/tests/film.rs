//! Accuracy of the film's means and variances, and the times of the shutter.
use dapple_camera::{Film, Filter, Shutter};
use dapple_math::PixelRect;
use dapple_testkit::Rng;
use glam::Vec3;

const ONE: PixelRect = PixelRect { x0: 0, y0: 0, x1: 1, y1: 1 };

/// With 2²⁶ samples, a constant stays exact, and a uniform variable keeps its mean and variance, with and without a
/// large offset.
#[test]
fn many_samples() {
    let mut film = Film::new(ONE);
    let n = 1u64 << 26;
    let (mut sum, mut sum2) = (0u64, 0u128);
    let mut x = 1u32;
    for _ in 0..n {
        // A full-period generator modulo 2³²; its top 16 bits are an exact fraction.
        x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let k = (x >> 16) as u64;
        sum += k;
        sum2 += (k * k) as u128;
        let u = k as f32 / 65536.0;
        film.add(0, 0, Vec3::new(1.0, u, 1000.0 + u), 1.0);
    }
    let mean = film.mean_at(0, 0);
    let exact = sum as f64 / n as f64 / 65536.0;
    assert_eq!(film.count(0, 0), n);
    assert_eq!(mean.x, 1.0);
    assert!((mean.y / exact - 1.0).abs() < 1e-9, "{}", mean.y);
    // 1000 + u is rounded to f32 in steps of 2⁻¹⁵, which is unbiased to 1e-6.
    assert!((mean.z - 1000.0 - exact).abs() < 1e-5, "{}", mean.z);
    let variance = (sum2 as f64 / n as f64 - (sum as f64 / n as f64).powi(2)) / 65536f64.powi(2) / n as f64;
    let got = film.variance().pixels[0];
    assert_eq!(got.x, 0.0);
    assert!((got.y as f64 / variance - 1.0).abs() < 1e-5, "{} {variance}", got.y);
    assert!((got.z as f64 / variance - 1.0).abs() < 1e-4, "{} {variance}", got.z);
}

/// One of 1e5 samples is 1e6, as of a sun. A sum of squares in single precision would lose its variance.
#[test]
fn rare_bright_samples() {
    let mut film = Film::new(ONE);
    let (n, bright) = (100_000u32, 1e6f64);
    for i in 0..n {
        film.add(0, 0, Vec3::splat(if i == 777 { bright as f32 } else { 1.0 }), 1.0);
    }
    let mean = (bright + (n - 1) as f64) / n as f64;
    let m2 = (bright - mean).powi(2) + (n - 1) as f64 * (1.0 - mean).powi(2);
    let variance = m2 / n as f64 / (n - 1) as f64;
    assert!((film.mean_at(0, 0).x / mean - 1.0).abs() < 1e-12);
    assert!((film.variance().pixels[0].x as f64 / variance - 1.0).abs() < 1e-6);
}

/// The estimated variance of the mean, averaged over many films, is the variance of their means.
#[test]
fn variance_is_that_of_the_mean() {
    let mut rng = Rng::new(3);
    let (films, n) = (20_000, 16);
    let (mut stated, mut spread) = (0.0, 0.0);
    for _ in 0..films {
        let mut film = Film::new(ONE);
        for _ in 0..n {
            film.add(0, 0, Vec3::splat(rng.f32()), 1.0);
        }
        stated += film.variance().pixels[0].x as f64;
        spread += (film.mean_at(0, 0).x - 0.5).powi(2);
    }
    let exact = 1.0 / 12.0 / n as f64;
    // The relative standard error of both is about √(2/films).
    assert!((stated / films as f64 / exact - 1.0).abs() < 0.01, "{}", stated / films as f64 / exact);
    assert!((spread / films as f64 / exact - 1.0).abs() < 0.04, "{}", spread / films as f64 / exact);
}

/// A constant image keeps its value with every filter, exactly so with filters without negative lobes.
#[test]
fn a_constant_picture_stays_constant() {
    for name in ["box", "tent", "gaussian", "mitchell", "blackman-harris"] {
        let filter: Filter = name.parse().unwrap();
        let (mut film, mut rng) = (Film::new(ONE), Rng::new(4));
        for _ in 0..100_000 {
            let (_, weight) = filter.sample(rng.vec2());
            film.add(0, 0, Vec3::splat(0.7), weight);
        }
        let (mean, se) = (film.mean().pixels[0].x, film.variance().pixels[0].x.sqrt());
        if filter == Filter::Mitchell {
            assert!((mean - 0.7).abs() < 4.0 * se && se < 2e-3, "{mean} ± {se}");
        } else {
            assert_eq!((mean, se), (0.7, 0.0), "{name}");
        }
    }
}

/// Merging adjoining parts in any order and grouping gives the same bits.
#[test]
fn merging_is_associative() {
    let mut rng = Rng::new(5);
    let mut first = 0;
    let mut part = |n: u32| {
        let mut film = Film::starting_at(ONE, |_, _| first);
        for _ in 0..n {
            film.add(0, 0, Vec3::new(rng.f32(), 1e3 * rng.f32(), 1e-3), 1.0);
        }
        first += u64::from(n);
        film
    };
    let parts: Vec<Film> = [1, 10, 1000, 0, 50].iter().map(|&n| part(n)).collect();
    let fold = |order: &[usize]| {
        let mut film = Film::new(ONE);
        order.iter().for_each(|&i| film.merge(&parts[i]).unwrap());
        film
    };
    let (a, mut b) = (fold(&[0, 1, 2, 3, 4]), fold(&[4, 2]));
    b.merge(&fold(&[3, 1, 0])).unwrap();
    assert_eq!((a.count(0, 0), &a), (1061, &b));
    assert_eq!(a.mean_at(0, 0), b.mean_at(0, 0));
    assert_eq!(a.variance(), b.variance());
}

#[test]
fn times_stay_within_the_shutter() {
    let shutter = Shutter { open: 1e6 - 0.1, close: 1e6 + 0.3 };
    let seconds = shutter.seconds();
    assert!((f64::from(seconds) - 0.4).abs() < 1e-7);
    assert_eq!((shutter.time(0.0), shutter.time(1.0)), (0.0, seconds));
    let (mut rng, mut sum) = (Rng::new(6), 0.0);
    for _ in 0..100_000 {
        let t = shutter.time(rng.f32());
        assert!((0.0..=seconds).contains(&t));
        sum += t as f64;
    }
    assert!((sum / 1e5 - 0.2).abs() < 4.0 * 0.4 / 12f64.sqrt() / 1e5f64.sqrt());
    // An exposure of a millisecond, one day into the animation, keeps the precision of u.
    let late = Shutter { open: 86_400.0, close: 86_400.001 };
    assert!(late.time(0.5) < late.time(0.5f32.next_up()));
    assert!(Shutter::default().is_instant() && Shutter { open: 2.0, close: 2.0 }.time(0.7) == 0.0);
    assert!(
        Shutter { open: 2.0, close: 1.0 }.is_instant() && Shutter { open: 2.0, close: 1.0 }.time(0.7) == 0.0
    );
}
