//! The s-th of n points, for a pattern and a key: the bridge between the two tracers.
//!
//! `point_*` keep the strata in order, for one integral at a time (the distribution tracer). `padded_*` permute the
//! order of the cells by the key, so that several integrals can share one sample index (the path tracer): without it
//! a grid would visit only the diagonal of the joint domain.
//!
//! All coordinates are below 1; those of random, stratified and Sobol points are multiples of 2^-24.

use crate::hash::{mix64, permute, unit};
use crate::{Key, sobol};
use glam::Vec2;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::fmt;
use std::str::FromStr;

/// How the points of an integral are laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pattern {
    /// Cell centres: deterministic midpoint quadrature, the same in every pixel.
    Grid,
    /// Independent.
    Random,
    /// One random point in each cell.
    Stratified,
    /// Owen-scrambled (0,2)-sequence.
    #[default]
    Sobol,
}

/// Not the name of a pattern.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownPattern(pub String);

impl fmt::Display for UnknownPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "'{}' is no pattern; choose grid, random, stratified or sobol", self.0)
    }
}

impl std::error::Error for UnknownPattern {}

impl FromStr for Pattern {
    type Err = UnknownPattern;
    fn from_str(s: &str) -> Result<Self, UnknownPattern> {
        match s {
            "grid" => Ok(Self::Grid),
            "random" => Ok(Self::Random),
            "stratified" => Ok(Self::Stratified),
            "sobol" => Ok(Self::Sobol),
            _ => Err(UnknownPattern(s.into())),
        }
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Grid => "grid",
            Self::Random => "random",
            Self::Stratified => "stratified",
            Self::Sobol => "sobol",
        })
    }
}

/// n = a·b, a ≥ b, as near to a square as n allows; a prime gives n×1. At most √n steps, one for powers of two and
/// squares; a caller with many points keeps the result (as [`crate::SampleSet`] does).
pub fn nearest_square(n: u32) -> [u32; 2] {
    if n.is_power_of_two() {
        let b = 1 << (n.trailing_zeros() / 2);
        return [n / b, b];
    }
    // A double holds every u32 and its root to 20 bits after the point: the floor is exact.
    let mut b = f64::from(n).sqrt() as u32;
    while b > 1 && !n.is_multiple_of(b) {
        b -= 1;
    }
    [n / b.max(1), b.max(1)]
}

/// s-th of n points in [0,1), strata in order. `s` ≥ n starts over in the same cells with other jitter.
#[inline]
pub fn point_1d(pattern: Pattern, s: u32, n: u32, key: Key) -> f32 {
    match pattern {
        Pattern::Sobol => sobol::point_1d(s, key),
        Pattern::Random => unit(random(s, key)[0]),
        Pattern::Grid => centre(s % n.max(1), n),
        Pattern::Stratified => within(s % n.max(1), n, random(s, key)[0]),
    }
}

/// s-th of n points in [0,1)², n split as [`nearest_square`], strata in order, x fastest. `s` ≥ n starts over in the
/// same cells with other jitter.
#[inline]
pub fn point_2d(pattern: Pattern, s: u32, n: u32, key: Key) -> Vec2 {
    match pattern {
        Pattern::Sobol => sobol::point_2d(s, key),
        Pattern::Random => random(s, key).map(unit).into(),
        _ => cell_2d(pattern, s % n.max(1), s, nearest_square(n), key),
    }
}

/// As [`point_1d`], with the order of the cells permuted by the key; `s` ≥ n starts over in another order.
#[inline]
pub fn padded_1d(pattern: Pattern, s: u32, n: u32, key: Key) -> f32 {
    match pattern {
        Pattern::Sobol => sobol::point_1d(sobol::pad(s, n, key), key),
        Pattern::Random => unit(random(s, key)[0]),
        Pattern::Grid => centre(permuted(s, n, key), n),
        Pattern::Stratified => within(permuted(s, n, key), n, random(s, key)[0]),
    }
}

/// As [`point_2d`], with the order of the cells permuted by the key; `s` ≥ n starts over in another order.
#[inline]
pub fn padded_2d(pattern: Pattern, s: u32, n: u32, key: Key) -> Vec2 {
    match pattern {
        Pattern::Sobol => sobol::point_2d(sobol::pad(s, n, key), key),
        Pattern::Random => random(s, key).map(unit).into(),
        _ => cell_2d(pattern, permuted(s, n, key), s, nearest_square(n), key),
    }
}

/// The point of sample `s` in cell `cell` of nx·ny, x fastest; for [`Pattern::Grid`] its centre, else a jittered point.
#[inline]
pub fn cell_2d(pattern: Pattern, cell: u32, s: u32, [nx, ny]: [u32; 2], key: Key) -> Vec2 {
    let (i, j) = (cell % nx.max(1), cell / nx.max(1));
    if pattern == Pattern::Grid {
        return Vec2::new(centre(i, nx), centre(j, ny));
    }
    let [x, y] = random(s, key);
    Vec2::new(within(i, nx, x), within(j, ny, y))
}

/// The order in which padded integrals visit their n cells: a bijection on 0..n chosen by the key, another one for each
/// round of n.
#[inline]
pub fn permuted(s: u32, n: u32, key: Key) -> u32 {
    let n = n.max(1);
    let round = u64::from(s / n);
    permute(s % n, n, mix64(key.bits() ^ 0x5EED ^ (round << 32)))
}

/// Independent point s of the key: the first two numbers of PCG32 [O'Neill 2014] on the key's stream, from a state hashed
/// from (key, s), so that any s costs the same.
#[inline]
fn random(s: u32, key: Key) -> [u32; 2] {
    let bits = key.bits();
    let mut pcg = Pcg32::new(mix64(bits ^ u64::from(s).wrapping_mul(0xD134_2543_DE82_EF95)), mix64(!bits));
    [pcg.next_u32(), pcg.next_u32()]
}

/// (cell + ½)/n.
fn centre(cell: u32, n: u32) -> f32 {
    let x = ((f64::from(cell) + 0.5) / f64::from(n.max(1))) as f32;
    x.min(1.0 - f32::EPSILON / 2.0)
}

/// A multiple of 2^-24 in [cell/n, (cell + 1)/n), in integers: never in a neighbouring cell by rounding. Above 2^24 cells
/// not every cell holds a multiple; the nearest below is taken (*approximation*: positions are off by at most 2^-24).
#[inline]
fn within(cell: u32, n: u32, jitter: u32) -> f32 {
    let n = u64::from(n.max(1));
    let first = |cell: u64| (cell << 24).div_ceil(n);
    let (low, high) = (first(u64::from(cell)), first(u64::from(cell) + 1));
    let x = low + (((high - low) * u64::from(jitter)) >> 32);
    x.min((1 << 24) - 1) as f32 * (1.0 / 16_777_216.0)
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
                // In f64 the product with a count is exact.
                let cell = |x: f32, n: u32| (f64::from(x) * f64::from(n)) as usize;
                let (mut plane, mut line) = (vec![0; n as usize], vec![0; n as usize]);
                // The second round starts over with other points.
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

    /// docs/science.md, "Points": the last cells of the largest count.
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
