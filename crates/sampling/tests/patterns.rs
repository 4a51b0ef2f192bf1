//! Properties of the patterns (docs/science.md, "Points"), and the exact bits that replay depends on.

use dapple_sampling::pattern::{nearest_square, permuted};
use dapple_sampling::{Key, Moments, Pattern, padded_1d, padded_2d, point_1d, point_2d, sobol};
use glam::Vec2;

const PATTERNS: [Pattern; 4] = [Pattern::Grid, Pattern::Random, Pattern::Stratified, Pattern::Sobol];

fn key(seed: u64) -> Key {
    Key::pixel(seed, 3, 7).at(0, 0u32)
}

/// These numbers must never change, because images of older versions are replayed and merged.
#[test]
fn points_are_a_promise() {
    assert_eq!(sobol::bits_1d(5, key(1)), 3_325_373_878);
    assert_eq!(sobol::bits_2d(1_000_000, key(1)), [2_354_564_464, 1_015_062_645]);
    assert_eq!([permuted(5, 1000, key(1)), sobol::pad(5, 1000, key(1))], [460, 12]);
    let scaled = |p: Vec2| (p * 16_777_216.0).to_array().map(|x| x as u32);
    assert_eq!(scaled(point_2d(Pattern::Random, 5, 0, key(1))), [4_987_458, 16_348_596]);
    assert_eq!(scaled(padded_2d(Pattern::Stratified, 5, 24, key(1))), [12_016_054, 16_670_061]);
    assert_eq!(padded_2d(Pattern::Grid, 5, 24, key(1)), Vec2::new(0.75, 0.875));
}

/// C17: no coordinate reaches 1 for any count.
#[test]
fn coordinates_stay_below_one() {
    for pattern in PATTERNS {
        for n in [1, 2, 3, 1000, 1 << 24, 16_777_259, u32::MAX] {
            for s in (0..200).chain((0..200).map(|i| n.saturating_sub(i + 1))) {
                for seed in 0..5 {
                    let k = key(seed);
                    let (p, q) = (point_2d(pattern, s, n, k), padded_2d(pattern, s, n, k));
                    for x in [p.x, p.y, q.x, q.y, point_1d(pattern, s, n, k), padded_1d(pattern, s, n, k)] {
                        assert!((0.0..1.0).contains(&x), "{pattern} {s} of {n}: {x}");
                    }
                }
            }
        }
    }
}

/// D14: each of a million cells gets exactly one point, in exact arithmetic.
#[test]
fn a_million_cells_get_one_point_each() {
    for (n, side) in [(1_000_000u32, 1000.0), (999_999, 0.0)] {
        let [nx, ny] = nearest_square(n);
        assert!(side == 0.0 || f64::from(nx) == side);
        let mut seen = vec![false; n as usize];
        for s in 0..n {
            let p = padded_2d(Pattern::Stratified, s, n, key(5));
            let [i, j] = [(p.x, nx), (p.y, ny)].map(|(x, n)| (f64::from(x) * f64::from(n)) as usize);
            let cell = j * nx as usize + i;
            assert!(!seen[cell], "cell {cell} of {n} twice");
            seen[cell] = true;
        }
    }
}

/// Returns the mean square error of the mean of `f` over n points, whose exact mean is `exact`, over `replicas` keys.
fn mse(pattern: Pattern, n: u32, replicas: u64, exact: f64, f: impl Fn(Vec2) -> f64) -> f64 {
    let square = |seed| {
        let k = key(seed);
        let sum: f64 = (0..n).map(|s| f(padded_2d(pattern, s, n, k))).sum();
        (sum / f64::from(n) - exact).powi(2)
    };
    (0..replicas).map(square).sum::<f64>() / replicas as f64
}

fn disk(p: Vec2) -> f64 {
    f64::from(p.length_squared() < 0.64)
}

const DISK: f64 = 0.16 * std::f64::consts::PI;

/// D05: the error keeps decreasing beyond 2^16 points: from 2^16 to 2^18 by 4^1.5 = 8 in theory, and at least by 3.
#[test]
fn sobol_improves_past_65536() {
    let at = |n| mse(Pattern::Sobol, n, 24, DISK, disk);
    let (before, after) = (at(1 << 16), at(1 << 18));
    assert!(after * 3.0 < before, "{before:e} {after:e}");
}

/// D07: for any count, the error is at most twice that of independent points, and from each power of four to the next
/// the mean square error decreases by more than a factor of 4.
#[test]
fn every_count_is_at_least_as_good_as_independent() {
    let e = std::f64::consts::E;
    let smooth = |p: Vec2| f64::from(p.x + p.y).exp();
    let exact = (e - 1.0).powi(2);
    let variance = ((e * e - 1.0) / 2.0).powi(2) - exact * exact;
    for pattern in [Pattern::Sobol, Pattern::Stratified] {
        for n in (1..=64).chain([100, 127, 128, 129, 200, 257, 500, 1000]) {
            let error = mse(pattern, n, 200, exact, smooth);
            assert!(error <= 2.0 * variance / f64::from(n), "{pattern} {n}: {error:e}");
            let error = mse(pattern, n, 200, DISK, disk);
            assert!(error <= 2.0 * DISK * (1.0 - DISK) / f64::from(n), "{pattern} {n}: {error:e}");
        }
    }
    let powers: Vec<f64> = (0..6).map(|i| mse(Pattern::Sobol, 1 << (2 * i), 400, exact, smooth)).collect();
    assert!(powers.windows(2).all(|w| w[1] < 0.25 * w[0]), "{powers:?}");
}

/// D06: the pads of a path of depth 1000 are uncorrelated. The test is the covariance of the coordinates of a vertex
/// over 1024 points; independent points give σ = 1/(12√N) = 0.0026.
#[test]
fn pads_are_uncorrelated() {
    let n = 1024;
    let one = [2u32, 3u32, 5u32, 7u32];
    let two = [0u32, 1u32, 4u32, 6u32];
    for pattern in [Pattern::Sobol, Pattern::Stratified, Pattern::Random] {
        for depth in (0..8).chain([100, 999]) {
            let base = Key::pixel(11, 4, 2);
            let line = |d| (0..n).map(|s| padded_1d(pattern, s, n, base.at(depth, d))).collect::<Vec<_>>();
            let plane = |d| (0..n).map(|s| padded_2d(pattern, s, n, base.at(depth, d))).collect::<Vec<_>>();
            let mut pads: Vec<Vec<f32>> = one.into_iter().map(line).collect();
            for points in two.map(plane) {
                pads.push(points.iter().map(|p| p.x).collect());
                pads.push(points.iter().map(|p| p.y).collect());
            }
            for (i, a) in pads.iter().enumerate() {
                for (j, b) in pads[..i].iter().enumerate() {
                    let covariance = covariance(a, b);
                    // 4σ is exceeded by one in 16 000 pairs. With 1980 pairs, the limit is 5σ.
                    assert!(
                        covariance.abs() < 5.0 / (12.0 * f64::from(n).sqrt()),
                        "{pattern} {depth}: {i} {j}"
                    );
                }
            }
        }
    }
}

fn covariance(a: &[f32], b: &[f32]) -> f64 {
    let product = a.iter().zip(b).map(|(&a, &b)| (f64::from(a) - 0.5) * (f64::from(b) - 0.5));
    product.sum::<f64>() / a.len() as f64
}

/// D06: the centred product of two pads has the error of independent points. Strata paired at random in blocks of B
/// have a ratio of (1 − 1/B²)²·B/(B − 1), which is 1.06 for 16. The test fails if two pads are in corresponding halves
/// at every index.
#[test]
fn products_of_pads_are_no_worse_than_independent() {
    let replicas = 4000;
    for pattern in [Pattern::Sobol, Pattern::Stratified] {
        for n in [16u32, 24, 64, 100] {
            let error = |a: u32, b: u32, kind: usize| {
                let square = |seed| {
                    let base = Key::pixel(seed, 1, 1);
                    let (a, b) = (base.at(3, a), base.at(4, b));
                    let line = |s, k| padded_1d(pattern, s, n, k);
                    let value = |s| match kind {
                        0 => [line(s, a), line(s, b)],
                        1 => [line(s, a), padded_2d(pattern, s, n, b).x],
                        2 => [padded_2d(pattern, s, n, a).x, padded_2d(pattern, s, n, b).x],
                        _ => [padded_2d(pattern, s, n, a).y, padded_2d(pattern, s, n, b).y],
                    };
                    let product = |[a, b]: [f32; 2]| (f64::from(a) - 0.5) * (f64::from(b) - 0.5);
                    ((0..n).map(|s| product(value(s))).sum::<f64>() / f64::from(n)).powi(2)
                };
                (0..replicas).map(square).collect::<Moments>()
            };
            for kind in 0..4 {
                let m = error(4u32, 6u32, kind);
                let independent = 1.0 / 144.0 / f64::from(n);
                let (ratio, se) = (m.mean / independent, m.standard_error() / independent);
                assert!(
                    ratio < 1.07 + 4.0 * se && se < 0.04,
                    "{pattern} {n} kind {kind}: {ratio:.3} ± {se:.3}"
                );
            }
        }
    }
}

/// The order of the cells depends neither on the position nor on the adjacent cell: a χ² test over (first, last) cells
/// of small counts.
#[test]
fn orders_are_even() {
    for n in [2u32, 3, 4, 5, 8, 9, 16, 23] {
        let tries = 400 * n * n;
        let mut pairs = vec![0.0; (n * n) as usize];
        for seed in 0..tries {
            let k = key(u64::from(seed));
            pairs[(permuted(0, n, k) * n + permuted(n - 1, n, k)) as usize] += 1.0;
        }
        let cells = n * (n - 1);
        let expected = f64::from(tries) / f64::from(cells);
        let chi2: f64 = (0..n * n)
            .filter(|c| c / n != c % n)
            .map(|c| (pairs[c as usize] - expected).powi(2) / expected)
            .sum();
        let freedom = f64::from(cells - 1).max(1.0);
        assert!(chi2 < freedom + 5.0 * (2.0 * freedom).sqrt() + 10.0, "{n}: {chi2:.1} of {freedom}");
    }
}
