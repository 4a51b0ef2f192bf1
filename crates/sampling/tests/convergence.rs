//! Convergence rates: fitted slopes of log MSE over log N, compared with docs/science.md, "Convergence rates".
//!
//! The full table (1000 replicas, to N = 2^14) is printed by
//! `cargo test --release -p dapple-sampling --test convergence -- --ignored --nocapture`.

use dapple_sampling::{Key, Pattern, point_1d, point_2d};
use dapple_testkit::Rng;
use glam::DVec2;
use std::f64::consts::{E, PI};

/// The points, with a random shift of the grid (a grid without shift has one error instead of a mean error).
#[derive(Clone, Copy, Debug)]
enum Points {
    Of(Pattern),
    ShiftedGrid,
}
use Points::{Of, ShiftedGrid};

fn line(points: Points, s: u32, n: u32, seed: u64) -> f64 {
    let key = Key::pixel(seed, 0, 0).at(0, 2u32);
    match points {
        Of(pattern) => f64::from(point_1d(pattern, s, n, key)),
        ShiftedGrid => (f64::from(point_1d(Pattern::Grid, s, n, key)) + Rng::new(seed).f64()).fract(),
    }
}

fn plane(points: Points, s: u32, n: u32, seed: u64) -> DVec2 {
    let key = Key::pixel(seed, 0, 0).at(0, 0u32);
    match points {
        Of(pattern) => point_2d(pattern, s, n, key).as_dvec2(),
        ShiftedGrid => {
            let mut rng = Rng::new(seed);
            let shift = DVec2::new(rng.f64(), rng.f64());
            (point_2d(Pattern::Grid, s, n, key).as_dvec2() + shift).fract()
        }
    }
}

/// Returns the slope and its standard error for N = 16, 16·step, 16·step², … up to `end`.
fn slope(step: u32, end: u32, replicas: u64, error: impl Fn(u32, u64) -> f64) -> (f64, f64) {
    let counts = std::iter::successors(Some(16u32), |n| Some(n * step)).take_while(|n| *n <= end);
    let points: Vec<(f64, f64)> = counts
        .map(|n| {
            let mse = (0..replicas).map(|seed| error(n, seed).powi(2)).sum::<f64>() / replicas as f64;
            (f64::from(n).ln(), mse.ln())
        })
        .collect();
    let k = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / k, points.iter().map(|p| p.1).sum::<f64>() / k);
    let sxx: f64 = points.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let sxy: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    // The variance of the log of a mean square over R normal replicas is 2/R.
    (sxy / sxx, (2.0 / replicas as f64 / sxx).sqrt())
}

type Line = (&'static str, fn(f64) -> f64, f64, [f64; 4]);
type Plane = (&'static str, fn(DVec2) -> f64, f64, [f64; 4]);

/// Expected slopes for independent points, jittered points, the shifted grid and Owen–Sobol points: N = 16 … 4096.
fn lines() -> [Line; 3] {
    let third = 1.0 / 3.0;
    [
        ("1-D smooth", f64::exp, E - 1.0, [-1.0, -3.0, -2.0, -3.0]),
        ("1-D step", |x| f64::from(x < 1.0 / 3.0), third, [-1.0, -2.0, -2.0, -2.0]),
        ("1-D kink", |x| (x - 1.0 / 3.0).abs(), 5.0 / 18.0, [-1.0, -2.99, -2.0, -2.99]),
    ]
}

fn planes() -> [Plane; 5] {
    let exp2 = (E - 1.0) * (E - 1.0);
    // ∫ ½(0.7 − 0.37x)² dx.
    let kink = (0.7f64.powi(3) - 0.33f64.powi(3)) / (6.0 * 0.37);
    [
        ("2-D smooth", |p| (p.x + p.y).exp(), exp2, [-1.01, -2.01, -1.0, -2.88]),
        ("2-D oblique edge", |p| f64::from(p.y < 0.3 + 0.37 * p.x), 0.485, [-1.01, -1.53, -1.03, -1.50]),
        (
            "2-D quarter disk",
            |p| f64::from(p.length_squared() < 0.64),
            0.16 * PI,
            [-1.01, -1.49, -0.99, -1.53],
        ),
        ("2-D axis edge", |p| f64::from(p.x < 1.0 / 3.0), 1.0 / 3.0, [-1.0, -1.5, -1.0, -2.0]),
        ("2-D kink", |p| (p.y - 0.3 - 0.37 * p.x).max(0.0), kink, [-1.01, -1.99, -1.0, -2.54]),
    ]
}

const POINTS: [Points; 4] = [Of(Pattern::Random), Of(Pattern::Stratified), ShiftedGrid, Of(Pattern::Sobol)];

/// Calls `check(name, points, expected, measured, standard error)` for the whole table.
fn table(replicas: u64, end: u32, mut check: impl FnMut(&str, Points, f64, f64, f64)) {
    for (name, f, exact, expected) in lines() {
        for (points, expected) in POINTS.into_iter().zip(expected) {
            let error =
                |n, seed| (0..n).map(|s| f(line(points, s, n, seed))).sum::<f64>() / f64::from(n) - exact;
            let (measured, se) = slope(2, end, replicas, error);
            check(name, points, expected, measured, se);
        }
    }
    for (name, f, exact, expected) in planes() {
        for (points, expected) in POINTS.into_iter().zip(expected) {
            // Powers of four, so that the cells are squares.
            let error =
                |n, seed| (0..n).map(|s| f(plane(points, s, n, seed))).sum::<f64>() / f64::from(n) - exact;
            let (measured, se) = slope(4, end, replicas, error);
            check(name, points, expected, measured, se);
        }
    }
}

/// Compares the slopes with the table: |Δ| ≤ 0.12 + 4 standard errors.
fn agrees_with_theory(replicas: u64, most: u32) {
    table(replicas, most, |name, points, expected, measured, se| {
        println!("{name:18} {points:?}: {measured:.3} ± {se:.3}, expected {expected:.2}");
        assert!(
            (measured - expected).abs() <= 0.12 + 4.0 * se,
            "{name}, {points:?}: {measured:.3} ± {se:.3}, expected {expected}"
        );
    });
}

/// N = 16 … 1024, six octaves.
#[test]
fn slopes_agree_with_theory() {
    agrees_with_theory(300, 1024);
}

/// N = 16 … 16384, ten octaves.
#[test]
#[ignore = "minutes; see the module comment"]
fn slopes_in_full() {
    agrees_with_theory(1000, 1 << 14);
}

/// The constant of the convergence of jittered points for smooth integrands, Var = (1/12)·N^(-1-2/d)·∫|∇f|², within 10
/// % at 10 000 replicas.
#[test]
fn jitter_has_its_constant() {
    let (n, replicas) = (64, 10_000);
    let check = |dimension: f64, gradient2: f64, error: &dyn Fn(u64) -> f64| {
        let mse = (0..replicas).map(|seed| error(seed).powi(2)).sum::<f64>() / replicas as f64;
        let ratio = mse / (gradient2 / 12.0 * f64::from(n).powf(-1.0 - 2.0 / dimension));
        assert!((ratio - 1.0).abs() < 0.1, "d = {dimension}: {ratio}");
    };
    let points = Of(Pattern::Stratified);
    let square = (E * E - 1.0) / 2.0;
    check(1.0, square, &|seed| {
        (0..n).map(|s| line(points, s, n, seed).exp()).sum::<f64>() / f64::from(n) - (E - 1.0)
    });
    check(2.0, 2.0 * square * square, &|seed| {
        let sum: f64 = (0..n).map(|s| plane(points, s, n, seed)).map(|p| (p.x + p.y).exp()).sum();
        sum / f64::from(n) - (E - 1.0).powi(2)
    });
}

/// The midpoint grid without shift has the exact error of the midpoint rule on a smooth integrand: error = −f″-term,
/// N^-2 in 1-D and N^-1 (side^-2) in 2-D.
#[test]
fn midpoint_grid_has_its_exact_error() {
    for n in [16u32, 64, 256] {
        let h = f64::from(n).recip();
        let sum: f64 = (0..n).map(|s| line(Of(Pattern::Grid), s, n, 0).exp()).sum::<f64>() * h;
        // Σ e^(h(i+½))·h = (e − 1)·(h/2)/sinh(h/2).
        let exact = (E - 1.0) * (h / 2.0) / (h / 2.0).sinh();
        assert!((sum - exact).abs() < 2e-7, "{n}: {sum} {exact}");
        let side = h.sqrt();
        let sum: f64 =
            (0..n).map(|s| plane(Of(Pattern::Grid), s, n, 0)).map(|p| (p.x + p.y).exp()).sum::<f64>() * h;
        let exact = ((E - 1.0) * (side / 2.0) / (side / 2.0).sinh()).powi(2);
        assert!((sum - exact).abs() < 4e-7, "{n}: {sum} {exact}");
    }
}
