//! Sample patterns: the s-th of n points for a pattern and a key, for both the path tracer and the distribution ray
//! tracer.
//!
//! `point_*` keep the strata in order, for one integral at a time (distribution ray tracer). `padded_*` permute the
//! order of the cells by the key, so that several integrals can share one sample index (path tracer). Without the
//! permutation, a grid would only cover the diagonal of the joint domain.
//!
//! All coordinates are below 1; those of random, stratified and Sobol points are multiples of 2^-24.

use crate::Key;
use crate::lanes::pattern::{self, Index};
use glam::Vec2;

pub use crate::arrangement::{Pattern, UnknownPattern};

/// Factors n = a·b with a ≥ b as close to each other as possible; a prime gives n×1. The search takes at most √n steps,
/// and one step for powers of two and squares. Callers with many points should store the result, as
/// [`crate::SampleSet`] does.
pub fn nearest_square(n: u32) -> [u32; 2] {
    if n.is_power_of_two() {
        let b = 1 << (n.trailing_zeros() / 2);
        return [n / b, b];
    }
    // An f64 represents every u32 exactly and its square root with at least 20 fractional bits, so that the floor is
    // exact.
    let mut b = f64::from(n).sqrt() as u32;
    while b > 1 && !n.is_multiple_of(b) {
        b -= 1;
    }
    [n / b.max(1), b.max(1)]
}

/// Returns the s-th of n points in [0,1), with the strata in order. For `s` ≥ n the cells repeat with different jitter.
#[inline]
pub fn point_1d(pattern: Pattern, s: u32, n: u32, key: Key) -> f32 {
    pattern::point_1d(pattern, Index::new(s), n, key)
}

/// Returns the s-th of n points in [0,1)². The cells are those of [`nearest_square`], in order, with x varying fastest.
/// For `s` ≥ n they repeat with different jitter.
#[inline]
pub fn point_2d(pattern: Pattern, s: u32, n: u32, key: Key) -> Vec2 {
    pattern::point_2d(pattern, Index::new(s), cells(pattern, n), key).into()
}

/// Like [`point_1d`], with the order of the cells permuted by the key. For `s` ≥ n the cells repeat in a different
/// order.
#[inline]
pub fn padded_1d(pattern: Pattern, s: u32, n: u32, key: Key) -> f32 {
    pattern::padded_1d(pattern, Index::new(s), n, key)
}

/// Like [`point_2d`], with the order of the cells permuted by the key. For `s` ≥ n the cells repeat in a different
/// order.
#[inline]
pub fn padded_2d(pattern: Pattern, s: u32, n: u32, key: Key) -> Vec2 {
    pattern::padded_2d(pattern, Index::new(s), cells(pattern, n), key).into()
}

/// Returns the number of cells along each axis; random and Sobol points have no cells, only a count.
#[inline]
pub fn cells(pattern: Pattern, n: u32) -> [u32; 2] {
    match pattern {
        Pattern::Grid | Pattern::Stratified => nearest_square(n),
        Pattern::Random | Pattern::Sobol => [n, 1],
    }
}

/// Returns the point of sample `s` in cell `cell` of nx·ny cells, with x varying fastest. It is the centre of the cell
/// for [`Pattern::Grid`], otherwise a jittered point.
#[inline]
pub fn cell_2d(pattern: Pattern, cell: u32, s: u32, size: [u32; 2], key: Key) -> Vec2 {
    pattern::cell_2d(pattern, cell, s, size, key).into()
}

/// Returns the cell of sample `s` for padded integrals. The order of the n cells is a bijection on 0..n selected by the
/// key, and a different one for each round of n samples.
#[inline]
pub fn permuted(s: u32, n: u32, key: Key) -> u32 {
    pattern::permuted(s, n, key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_square_splits_exactly() {
        for n in 1..2000 {
            let [a, b] = nearest_square(n);
            assert_eq!(a * b, n);
            assert!(a >= b);
        }
        assert_eq!(nearest_square(16), [4, 4]);
        assert_eq!(nearest_square(12), [4, 3]);
        assert_eq!(nearest_square(7), [7, 1]);
    }

    #[test]
    fn every_cell_gets_one_point() {
        for pattern in [Pattern::Grid, Pattern::Stratified] {
            for n in [1u32, 2, 5, 12, 64, 1000, 65_521] {
                let [nx, ny] = nearest_square(n);
                // In f64, the product with a count is exact.
                let cell = |x: f32, n: u32| (f64::from(x) * f64::from(n)) as usize;
                let (mut plane, mut line) = (vec![0; n as usize], vec![0; n as usize]);
                // The second round uses the same cells with different points.
                for s in 0..2 * n {
                    let p = padded_2d(pattern, s, n, Key::pixel(3, 1, 4));
                    plane[cell(p.y, ny) * nx as usize + cell(p.x, nx)] += 1;
                    line[cell(padded_1d(pattern, s, n, Key::pixel(3, 1, 4)), n)] += 1;
                }
                assert!(plane.iter().chain(&line).all(|&c| c == 2), "{pattern} {n}");
            }
        }
    }

    #[test]
    fn a_second_round_is_other_points() {
        let key = Key::pixel(3, 1, 4);
        let point = |s| padded_2d(Pattern::Stratified, s, 64, key);
        assert!((0..64).all(|s| (0..64).all(|t| point(s) != point(64 + t))));
        assert!((0..64).any(|s| permuted(s, 64, key) != permuted(64 + s, 64, key)));
    }

    /// docs/science.md, "Points": the last cells of the largest possible count.
    #[test]
    fn cells_are_found_up_to_2_to_the_32() {
        let n = u32::MAX;
        assert_eq!(nearest_square(n), [65_537, 65_535]);
        for s in [0, 1, 65_536, 65_537, n / 2, n - 2, n - 1] {
            let p = point_2d(Pattern::Stratified, s, n, Key::pixel(0, 0, 0));
            let [i, j] = [(p.x, 65_537.0), (p.y, 65_535.0)].map(|(x, n)| (f64::from(x) * n) as u32);
            assert_eq!([i, j], [s % 65_537, s / 65_537]);
            let x = f64::from(point_1d(Pattern::Stratified, s, n, Key::pixel(0, 0, 0)));
            assert!((x - f64::from(s) / f64::from(n)).abs() <= 1.0 / 16_777_216.0);
        }
    }

    #[test]
    fn points_stay_in_range() {
        for pattern in [Pattern::Grid, Pattern::Random, Pattern::Stratified, Pattern::Sobol] {
            for s in 0..10_000 {
                let p = padded_2d(pattern, s, 10_000, Key::pixel(1, 2, 3));
                assert!(p.min_element() >= 0.0 && p.max_element() < 1.0);
            }
            let last = point_1d(pattern, u32::MAX - 1, u32::MAX, Key::pixel(0, 0, 0));
            assert!((0.0..1.0).contains(&last));
        }
    }
}
