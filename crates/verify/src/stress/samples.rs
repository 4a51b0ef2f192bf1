//! Stress cases D04 to D07, D13, D14: accumulation, sampling patterns and pixel filters with very many samples.

use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{moments, run, seen, square};
use crate::tally::Tally;
use dapple_integrator::Dimension;
use dapple_integrator::Settings;
use dapple_integrator::camera::{Film, Filter};
use dapple_integrator::lights::Environment;
use dapple_integrator::math::PixelRect;
use dapple_integrator::sampling::{Key, Moments, Pattern, padded_2d, pattern, point_2d};
use glam::{DVec3, Vec2, Vec3};
use std::collections::HashSet;
use std::f64::consts::E;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "D04",
        title: "2²⁸ samples into one pixel",
        naive: "an f32 sum of ones stops at 16 777 216",
        source: "Chan 1979; docs/science.md, \"Sums\"",
        check: Check::Run(accumulation),
    },
    Case {
        id: "D05",
        title: "patterns beyond 2¹⁶ points",
        naive: "the sequence starts over after 65 536 points: more samples, the same error",
        source: "Burley 2020; docs/science.md, \"Points\"",
        check: Check::Run(length),
    },
    Case {
        id: "D06",
        title: "sample dimensions of a path with a thousand vertices",
        naive: "dimensions run out and repeat: correlated decisions",
        source: "Burley 2020, §4; docs/science.md, \"Points\"",
        check: Check::Run(dimensions),
    },
    Case {
        id: "D07",
        title: "any number of samples",
        naive: "good points at powers of two, worse than random points in between",
        source: "docs/science.md, \"Points\"",
        check: Check::Run(any_count),
    },
    Case {
        id: "D13",
        title: "pixel filters keep a constant image constant",
        naive: "filter weights that do not add up to 1",
        source: "Ernst 2006; docs/science.md, \"Pixel filters\"",
        check: Check::Run(filters),
    },
    Case {
        id: "D14",
        title: "stratification with a million cells",
        naive: "⌊i√N⌋ in f32 puts points into the neighbouring cell",
        source: "docs/science.md, \"Points\"",
        check: Check::Run(cells),
    },
];

fn accumulation(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let n = 1u32 << effort.of(20, 28, 30);
    let mut film = Film::new(PixelRect { x0: 0, y0: 0, x1: 1, y1: 1 });
    let (mut noise, mut exact) = (Noise(71), 0u64);
    for _ in 0..n {
        // A multiple of 2⁻²⁴, whose sum is exact in integers, and one.
        let steps = noise.bits() >> 40;
        exact += steps;
        film.add(0, 0, Vec3::new(steps as f32 / 16_777_216.0, 1.0, 1e6), 1.0);
    }
    let mean = film.mean_at(0, 0);
    let exact = exact as f64 / 16_777_216.0 / f64::from(n);
    tally.within("relative error of the mean of uniform numbers", mean.x / exact - 1.0, 0.0, 1e-7);
    tally.within("mean of ones", mean.y, 1.0, 1e-7);
    tally.within("relative error of the mean of 1e6", mean.z / 1e6 - 1.0, 0.0, 1e-7);
    tally.within(
        "variance of uniform numbers",
        f64::from(film.variance().pixels[0].x) * f64::from(n),
        1.0 / 12.0,
        1e-3,
    );
    tally.finish()
}

/// Mean of e^(x+y) over n points minus the integral.
fn smooth_error(pattern: Pattern, n: u32, seed: u64) -> f64 {
    let key = Key::pixel(seed, 3, 9).at(0, Dimension::Pixel);
    let value = |s: u32| {
        let p = padded_2d(pattern, s, n, key);
        (f64::from(p.x) + f64::from(p.y)).exp()
    };
    (0..n).map(value).sum::<f64>() / f64::from(n) - (E - 1.0).powi(2)
}

/// Mean squared error of the estimated area of the quarter disk x² + y² < 0.64.
fn edge_mse(pattern: Pattern, n: u32, replicas: u64) -> f64 {
    let error = |seed: u64| {
        let key = Key::pixel(seed, 5, 7).at(0, Dimension::Pixel);
        let inside = (0..n).filter(|&s| {
            let p = padded_2d(pattern, s, n, key);
            p.length_squared() < 0.64
        });
        (inside.count() as f64 / f64::from(n) - 0.16 * std::f64::consts::PI).powi(2)
    };
    (0..replicas).map(error).sum::<f64>() / replicas as f64
}

fn length(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let (low, high, replicas) = (12u32, effort.of(17, 19, 21), effort.of(16, 64, 256));
    let first = edge_mse(Pattern::Sobol, 1 << low, replicas);
    let last = edge_mse(Pattern::Sobol, 1 << high, replicas);
    let slope = (last / first).log2() / f64::from(high - low);
    // The relative standard deviation of a ratio of two mean squares is √(2·2/replicas).
    let error = (4.0 / replicas as f64).sqrt() / std::f64::consts::LN_2 / f64::from(high - low);
    tally.within("rate of a quarter disk beyond 2¹⁶", slope, -1.53, 0.1 + 4.0 * error);
    let key = Key::pixel(1, 2, 3).at(0, Dimension::Lobe);
    let bits = |s: u32| {
        let p = point_2d(Pattern::Sobol, s, 1 << 18, key);
        (p.x.to_bits(), p.y.to_bits())
    };
    let block: HashSet<(u32, u32)> = (0..65_536).map(bits).collect();
    let again = (65_536..131_072).filter(|&s| block.contains(&bits(s))).count();
    // Of 2⁴⁸ positions a few may coincide.
    tally.at_most("points of the second 65 536 that occur in the first", again as f64, 2.0);
    tally.finish()
}

fn dimensions(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let n = 1024;
    let decisions =
        [Dimension::Lobe, Dimension::Direction, Dimension::Light, Dimension::LightPoint, Dimension::Roulette];
    let pixel = Key::pixel(4, 8, 15);
    let column = |depth: u32, d: Dimension| -> Vec<Vec2> {
        (0..n).map(|s| padded_2d(Pattern::Sobol, s, n, pixel.at(depth, d))).collect()
    };
    let (mut sums, mut squares, mut pairs) = (0.0f64, 0.0f64, 0.0);
    let mut before: Option<Vec<Vec2>> = None;
    for depth in 0..effort.of(40, 1000, 10_000) {
        for d in decisions {
            let now = column(depth, d);
            if let Some(before) = &before {
                for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let half = |v: f32| f64::from(v) - 0.5;
                    let c: f64 = before.iter().zip(&now).map(|(p, q)| half(p[a]) * half(q[b])).sum();
                    let scaled = 12.0 * c / f64::from(n).sqrt();
                    sums += scaled;
                    squares += scaled * scaled;
                    pairs += 1.0;
                }
            }
            before = Some(now);
        }
    }
    // Correlations times √N of independent paddings have mean 0. Padding pairs the points of blocks of 16 at random
    // without replacement; k values that share the mean of their block, paired in this way, have k/(k − 1) times the
    // variance of independent ones.
    tally.within("mean of the scaled correlations", sums / pairs, 0.0, 4.0 * f64::sqrt(1.07 / pairs));
    tally.within(
        "their mean square",
        squares / pairs,
        16.0 / 15.0,
        4.0 * 1.07 * f64::sqrt(2.0 / pairs) + 0.005,
    );
    tally.finish()
}

fn any_count(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let replicas = effort.of(100, 600, 10_000);
    // Var e^x e^y = ((e² − 1)/2)² − (e − 1)⁴.
    let variance = ((E * E - 1.0) / 2.0).powi(2) - (E - 1.0).powi(4);
    let mut last = f64::INFINITY;
    for n in [1u32, 2, 3, 4, 5, 7, 8, 12, 16, 17, 31, 32, 63, 64, 100, 128, 200, 256, 257, 512, 1000, 1024] {
        for pattern in [Pattern::Sobol, Pattern::Stratified] {
            let mse = (0..replicas).map(|seed| smooth_error(pattern, n, seed).powi(2)).sum::<f64>()
                / replicas as f64;
            let ratio = mse / (variance / f64::from(n));
            tally.at_most(format!("{pattern}, {n} points: MSE over that of independent points"), ratio, 2.0);
            if pattern == Pattern::Sobol && n.is_power_of_two() {
                tally.at_most(
                    format!("{pattern}, {n} points: MSE over that of half as many"),
                    mse / last,
                    1.0,
                );
                last = mse;
            }
        }
    }
    tally.finish()
}

fn filters(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let filters = [
        Filter::default(),
        Filter::Box { radius: 3.0 },
        Filter::Tent,
        Filter::Gaussian,
        Filter::Mitchell,
        Filter::BlackmanHarris,
    ];
    for filter in filters {
        let mut builder = seen(DVec3::ZERO, DVec3::NEG_Z, 1.0);
        builder.environment(Environment::constant(Vec3::splat(0.375)));
        let Ok(scene) = builder.build() else { continue };
        let m = moments(&run(&scene, &Settings { filter, ..square(effort.of(8, 32, 128), 64) }));
        if filter == Filter::Mitchell {
            tally.mean(filter.to_string(), &m, 0.375, 0.02);
        } else {
            tally.exactly(format!("{filter}: mean"), m.mean, 0.375);
            tally.exactly(format!("{filter}: spread"), m.variance(), 0.0);
        }
    }
    tally.finish()
}

fn cells(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for n in [1_000_000u32, 999_983, effort.of(1 << 20, 1 << 22, 1 << 24)] {
        let [nx, ny] = pattern::nearest_square(n);
        let mut counts = vec![0u8; n as usize];
        for s in 0..n {
            let p = padded_2d(Pattern::Stratified, s, n, Key::pixel(16, 23, 42));
            let at = |x: f32, n: u32| (f64::from(x) * f64::from(n)) as usize;
            let i = at(p.y, ny) * nx as usize + at(p.x, nx);
            counts[i] = counts[i].saturating_add(1);
        }
        tally.none(
            format!("of {n} cells without exactly one point"),
            counts.iter().filter(|c| **c != 1).count() as u64,
        );
    }
    let spread: Moments = (0..100).map(|seed| smooth_error(Pattern::Stratified, 10_000, seed)).collect();
    tally.mean("10 000 stratified points: error", &spread, 0.0, 1e-3);
    tally.finish()
}
