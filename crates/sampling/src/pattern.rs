//! The s-th of n points, for a pattern and a key: the bridge between the two tracers.
//!
//! `point_*` keep the strata in order, for one integral at a time (the distribution tracer). `padded_*` permute the
//! order of the cells by the key, so that several integrals can share one sample index (the path tracer): without it
//! a grid would visit only the diagonal of the joint domain.

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

/// n = a·b with a ≤ b as near to a square as n allows; a prime gives 1×n.
pub fn nearest_square(n: u32) -> [u32; 2] {
    let mut a = (f64::from(n)).sqrt() as u32 + 1;
    while a > 1 && (n % a != 0 || u64::from(a) * u64::from(a) > u64::from(n)) {
        a -= 1;
    }
    [n / a.max(1), a.max(1)]
}

/// s-th of n points in [0,1), strata in order. `s` ≥ n starts over in the same cells with other jitter.
#[inline]
pub fn point_1d(pattern: Pattern, s: u32, n: u32, key: Key) -> f32 {
    match pattern {
        Pattern::Sobol => sobol::point_1d(s, key),
        Pattern::Random => random(s, key).x,
        Pattern::Grid => in_cell(s % n.max(1), n, 0.5),
        Pattern::Stratified => in_cell(s % n.max(1), n, random(s, key).x),
    }
}

/// s-th of n points in [0,1)², n split as [`nearest_square`], strata in order, x fastest.
#[inline]
pub fn point_2d(pattern: Pattern, s: u32, n: u32, key: Key) -> Vec2 {
    match pattern {
        Pattern::Sobol => sobol::point_2d(s, key),
        Pattern::Random => random(s, key),
        _ => cell_2d(pattern, s, nearest_square(n), key),
    }
}

/// s-th of nx·ny points of a grid or stratified pattern with the cells given.
pub fn cell_2d(pattern: Pattern, s: u32, [nx, ny]: [u32; 2], key: Key) -> Vec2 {
    let cell = s % nx.saturating_mul(ny).max(1);
    let jitter = if pattern == Pattern::Grid { Vec2::splat(0.5) } else { random(s, key) };
    Vec2::new(in_cell(cell % nx.max(1), nx, jitter.x), in_cell(cell / nx.max(1), ny, jitter.y))
}

/// As [`point_1d`], with the order of the cells permuted by the key.
#[inline]
pub fn padded_1d(pattern: Pattern, s: u32, n: u32, key: Key) -> f32 {
    match pattern {
        Pattern::Sobol | Pattern::Random => point_1d(pattern, s, n, key),
        _ => point_1d(pattern, permute(s, n, mix64(key.bits() ^ 0x5EED)), n, key),
    }
}

/// As [`point_2d`], with the order of the cells permuted by the key.
#[inline]
pub fn padded_2d(pattern: Pattern, s: u32, n: u32, key: Key) -> Vec2 {
    match pattern {
        Pattern::Sobol | Pattern::Random => point_2d(pattern, s, n, key),
        _ => point_2d(pattern, permute(s, n, mix64(key.bits() ^ 0x5EED)), n, key),
    }
}

/// The order in which paired integrals visit their strata: a bijection on 0..n chosen by the key.
pub fn permuted(s: u32, n: u32, key: Key) -> u32 {
    permute(s, n, mix64(key.bits() ^ 0x5EED))
}

/// Independent point s of the key: the first two numbers of PCG32 stream `key`, state hashed from (key, s).
fn random(s: u32, key: Key) -> Vec2 {
    let bits = key.bits();
    let mut pcg = Pcg32::new(mix64(bits ^ u64::from(s).wrapping_mul(0xD134_2543_DE82_EF95)), mix64(!bits));
    Vec2::new(unit(pcg.next_u32()), unit(pcg.next_u32()))
}

/// (cell + jitter) / n in f64, kept below 1 and inside the cell.
fn in_cell(cell: u32, n: u32, jitter: f32) -> f32 {
    let x = ((f64::from(cell) + f64::from(jitter)) / f64::from(n.max(1))) as f32;
    x.min(1.0 - f32::EPSILON / 2.0)
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
            for n in [1u32, 2, 5, 12, 64, 1000] {
                let [nx, ny] = nearest_square(n);
                let mut seen = vec![0; n as usize];
                for s in 0..n {
                    let p = padded_2d(pattern, s, n, Key::pixel(3, 1, 4));
                    seen[(p.y * ny as f32) as usize * nx as usize + (p.x * nx as f32) as usize] += 1;
                }
                assert!(seen.iter().all(|&c| c == 1), "{pattern} {n}");
            }
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
