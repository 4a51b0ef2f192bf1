//! Filters: the density of the warped points times their weight is the filter.
use dapple_camera::Filter;
use dapple_testkit::{Rng, chi_square::ChiSquare, quadrature};
use glam::Vec2;
use std::f64::consts::PI;

const ALL: [Filter; 7] = [
    Filter::Box { radius: 0.5 },
    Filter::Box { radius: 1.0 },
    Filter::Box { radius: 0.3 },
    Filter::Tent,
    Filter::Gaussian,
    Filter::Mitchell,
    Filter::BlackmanHarris,
];

/// One axis of the filter by its textbook formula, not normalised.
fn axis(filter: Filter, x: f64) -> f64 {
    let x = x.abs();
    if x >= filter.radius() as f64 {
        return 0.0;
    }
    match filter {
        Filter::Box { .. } => 1.0,
        Filter::Tent => 1.0 - x,
        Filter::Gaussian => (-x * x / 0.5).exp() - (-1.5f64 * 1.5 / 0.5).exp(),
        Filter::BlackmanHarris => {
            let t = PI * (x / 1.5 + 1.0);
            0.35875 - 0.48829 * t.cos() + 0.14128 * (2.0 * t).cos() - 0.01168 * (3.0 * t).cos()
        }
        Filter::Mitchell => {
            let (b, c) = (1.0 / 3.0, 1.0 / 3.0);
            let (x2, x3) = (x * x, x * x * x);
            let polynomial = if x < 1.0 {
                (12.0 - 9.0 * b - 6.0 * c) * x3 + (-18.0 + 12.0 * b + 6.0 * c) * x2 + 6.0 - 2.0 * b
            } else {
                (-b - 6.0 * c) * x3
                    + (6.0 * b + 30.0 * c) * x2
                    + (-12.0 * b - 48.0 * c) * x
                    + 8.0 * b
                    + 24.0 * c
            };
            polynomial / 6.0
        }
    }
}

fn integral(filter: Filter, f: impl Fn(f64) -> f64) -> f64 {
    let r = filter.radius() as f64;
    // Split at the junction and the zero of the Mitchell filter.
    let ends = [-r, -8.0 / 7.0, -1.0, 0.0, 1.0, 8.0 / 7.0, r].map(|x: f64| x.clamp(-r, r));
    let part = |w: &[f64]| if w[0] < w[1] { quadrature::line(&f, w[0], w[1], 1e-10) } else { 0.0 };
    ends.windows(2).map(part).sum()
}

#[test]
fn points_follow_the_size_of_the_filter() {
    let test = ChiSquare::family(ALL.len());
    for filter in ALL {
        let r = filter.radius();
        let total = integral(filter, |x| axis(filter, x).abs());
        let result = test.plane(
            Vec2::splat(-r),
            Vec2::splat(r),
            |u, _| Some(filter.sample(u).0),
            |p| ((axis(filter, p.x as f64) / total).abs() * (axis(filter, p.y as f64) / total).abs()) as f32,
        );
        assert!(result.passed(), "{filter}: {result}");
    }
}

#[test]
fn weights_are_sign_times_size_and_average_one() {
    for filter in ALL {
        let (plain, size) =
            (integral(filter, |x| axis(filter, x)), integral(filter, |x| axis(filter, x).abs()));
        let norm = (size / plain).powi(2);
        let (mut rng, n) = (Rng::new(1), 400_000);
        let mut sum = 0.0;
        for _ in 0..n {
            let (p, w) = filter.sample(rng.vec2());
            let sign = (axis(filter, p.x as f64) * axis(filter, p.y as f64)).signum();
            let on_border = [p.x, p.y].iter().any(|x| (x.abs() - 8.0 / 7.0).abs() < 1e-5 || x.abs() > 1.9999);
            assert!(on_border || (w as f64 - sign * norm).abs() < 1e-4, "{filter} at {p}: {w}");
            assert!(filter == Filter::Mitchell || w == 1.0);
            sum += w as f64;
        }
        let deviation = (norm * norm - 1.0).max(0.0).sqrt() / (n as f64).sqrt();
        assert!((sum / n as f64 - 1.0).abs() <= 4.0 * deviation + 1e-6, "{filter}: {}", sum / n as f64);
    }
}

/// With a grid of points as quadrature, Σ weight·g is ∫ filter·g for smooth g, so that the moments are those of the
/// filter.
#[test]
fn moments_are_those_of_the_filter() {
    for filter in ALL {
        let plain = integral(filter, |x| axis(filter, x));
        let second = integral(filter, |x| axis(filter, x) * x * x) / plain;
        let n = 1000;
        let (mut zeroth, mut first, mut got) = (0.0, 0.0, 0.0);
        for i in 0..n * n {
            let u = (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32;
            let (p, w) = filter.sample(u);
            zeroth += w as f64;
            first += (w * p.x) as f64;
            got += w as f64 * (p.x as f64 * p.x as f64);
        }
        let count = (n * n) as f64;
        // The grid is off by one cell where the weight changes sign.
        let tolerance = if filter == Filter::Mitchell { 4e-3 } else { 1e-4 };
        assert!((zeroth / count - 1.0).abs() < tolerance, "{filter}: {}", zeroth / count);
        assert!((first / count).abs() < 1e-5, "{filter}: {}", first / count);
        assert!((got / count - second).abs() < tolerance, "{filter}: {} {second}", got / count);
    }
}

/// Strata stay strata, because each coordinate increases with its u.
#[test]
fn the_warp_is_monotone() {
    for filter in ALL {
        let mut last = -filter.radius();
        for i in 0..1 << 16 {
            let x = filter.sample(Vec2::new(i as f32 / 65536.0, 0.5)).0.x;
            assert!(x >= last && x.abs() <= filter.radius(), "{filter} at {i}: {x} after {last}");
            last = x;
        }
        let end = 1.0 - f32::EPSILON / 2.0;
        assert!(filter.sample(Vec2::new(0.0, end)).0.abs().max_element() <= filter.radius());
    }
}
