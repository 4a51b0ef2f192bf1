//! Sample patterns over words: the s-th of n points. `r` is `s` with its bits reversed, of which Sobol points are made.

use super::hash::{mix, permute};
use super::integer::{OfLane, by_lane, divide, multiply_high, settle};
use super::{Keyx, sobol};
use crate::arrangement::Pattern;
use dapple_math::lanes::{Real, Vec2x, Word};

/// The number of a sample in each lane, and the same number with its bits reversed.
#[derive(Clone, Copy, Debug)]
pub struct Index<W> {
    s: W,
    r: W,
}

impl<W: Word> Index<W> {
    /// Returns the index `s`. It is made once per sample and used for all of its points.
    #[inline(always)]
    pub fn new(s: W) -> Self {
        Self { s, r: s.reverse_bits() }
    }

    /// Returns the number of the sample.
    #[inline(always)]
    pub fn number(self) -> W {
        self.s
    }
}

/// Returns the s-th of n points in [0,1), with the strata in order. For `s` ≥ n the cells repeat with different jitter.
#[inline(always)]
pub fn point_1d<W: Word>(pattern: Pattern, s: Index<W>, n: u32, key: Keyx<W>) -> W::Real {
    match pattern {
        Pattern::Sobol => sobol::point_1d(s.r, key),
        Pattern::Random => random(s.s, key)[0].unit(),
        Pattern::Grid => centre(divide(s.s, n).1, n),
        Pattern::Stratified => within(divide(s.s, n).1, n, random(s.s, key)[0]),
    }
}

/// Returns the s-th of n points in [0,1)², n = nx·ny, in the cells of a grid of nx·ny, in order, with x varying fastest.
/// For `s` ≥ n they repeat with different jitter.
#[inline(always)]
pub fn point_2d<W: Word>(pattern: Pattern, s: Index<W>, size: [u32; 2], key: Keyx<W>) -> Vec2x<W::Real> {
    match pattern {
        Pattern::Sobol => sobol::point_2d(s.r, key),
        Pattern::Random => random_2d(s.s, key),
        _ => cell_2d(pattern, divide(s.s, count(size)).1, s.s, size, key),
    }
}

/// Like [`point_1d`], with the order of the cells permuted by the key. For `s` ≥ n the cells repeat in a different
/// order.
#[inline(always)]
pub fn padded_1d<W: Word>(pattern: Pattern, s: Index<W>, n: u32, key: Keyx<W>) -> W::Real {
    match pattern {
        Pattern::Sobol => sobol::point_1d(sobol::pad(s.r, n, key), key),
        Pattern::Random => random(s.s, key)[0].unit(),
        Pattern::Grid => centre(permuted(s.s, n, key), n),
        Pattern::Stratified => within(permuted(s.s, n, key), n, random(s.s, key)[0]),
    }
}

/// Like [`point_2d`], with the order of the cells permuted by the key. For `s` ≥ n the cells repeat in a different
/// order.
#[inline(always)]
pub fn padded_2d<W: Word>(pattern: Pattern, s: Index<W>, size: [u32; 2], key: Keyx<W>) -> Vec2x<W::Real> {
    match pattern {
        Pattern::Sobol => sobol::point_2d(sobol::pad(s.r, count(size), key), key),
        Pattern::Random => random_2d(s.s, key),
        _ => cell_2d(pattern, permuted(s.s, count(size), key), s.s, size, key),
    }
}

#[inline(always)]
fn count([nx, ny]: [u32; 2]) -> u32 {
    nx.saturating_mul(ny)
}

/// Returns the point of sample `s` in cell `cell` of nx·ny cells, with x varying fastest. It is the centre of the cell
/// for [`Pattern::Grid`], otherwise a jittered point.
#[inline(always)]
pub fn cell_2d<W: Word>(pattern: Pattern, cell: W, s: W, [nx, ny]: [u32; 2], key: Keyx<W>) -> Vec2x<W::Real> {
    let (j, i) = divide(cell, nx);
    if pattern == Pattern::Grid {
        return Vec2x::new(centre(i, nx), centre(j, ny));
    }
    let [x, y] = random(s, key);
    Vec2x::new(within(i, nx, x), within(j, ny, y))
}

/// Returns the cell of sample `s` for padded integrals. The order of the n cells is a bijection on 0..n selected by the
/// key, and a different one for each round of n samples.
#[inline(always)]
pub fn permuted<W: Word>(s: W, n: u32, key: Keyx<W>) -> W {
    let (round, s) = divide(s, n);
    let [a, b] = key.words();
    permute(s, n, mix([a ^ round, b ^ W::splat(ORDER)]))
}

/// Distinguishes the order of the cells, and random points, from each other.
const ORDER: u32 = 0x5eed_0bed;
const POINT: u32 = 0xd134_2543;

/// Returns the independent random point s of the key: its hash.
#[inline(always)]
fn random<W: Word>(s: W, key: Keyx<W>) -> [W; 2] {
    let [a, b] = key.words();
    mix([a ^ s, b ^ W::splat(POINT)])
}

#[inline(always)]
fn random_2d<W: Word>(s: W, key: Keyx<W>) -> Vec2x<W::Real> {
    let [x, y] = random(s, key);
    Vec2x::new(x.unit(), y.unit())
}

/// Returns (cell + ½)/n, to within 2 ulp, and correctly rounded for n < 2²³.
#[inline(always)]
fn centre<W: Word>(cell: W, n: u32) -> W::Real {
    let x = (cell.to_real() + W::Real::splat(0.5)) / W::Real::splat(n.max(1) as f32);
    x.min(W::Real::splat(1.0 - f32::EPSILON / 2.0))
}

/// Returns a multiple of 2⁻²⁴ in [cell/n, (cell + 1)/n). It is computed in integers, so that rounding never moves it to
/// an adjacent cell. Above 2²⁴ cells, not every cell contains a multiple, and the nearest one below is used
/// (*approximation*: positions are off by at most 2⁻²⁴).
#[inline(always)]
fn within<W: Word>(cell: W, n: u32, jitter: W) -> W::Real {
    let n = n.max(1);
    let (low, high) = (first(cell, n), first(cell.wrapping_add(W::splat(1)), n));
    let x = low.wrapping_add(multiply_high(high.wrapping_sub(low), jitter));
    let end = W::splat((1 << 24) - 1);
    W::select(x.lt(end), x, end).int_to_real() * W::Real::splat(1.0 / 16_777_216.0)
}

/// Returns ⌈cell·2²⁴/n⌉ for cell ≤ n, exactly.
#[inline(always)]
fn first<W: Word>(cell: W, n: u32) -> W {
    if W::Real::LANES == 1 {
        let mut lane = [0];
        cell.store(&mut lane);
        return W::splat(First(n).of(lane[0], [0; 2]));
    }
    if n >= 1 << 24 {
        return by_lane(cell.eq(cell), cell, [cell; 2], First(n));
    }
    // ⌊(cell·2²⁴ + n − 1)/n⌋, whose quotient in f32 is off by less than 8, so that the remainder is below 2²⁸.
    let q = (cell.int_to_real() * W::Real::splat(16_777_216.0 / n as f32)).to_int();
    let rest = (cell << 24).wrapping_add(W::splat(n - 1)).wrapping_sub(q.wrapping_mul(W::splat(n)));
    settle(q, rest, n, 1.0 / n as f32).0
}

/// [`first`] of one lane.
#[derive(Clone, Copy)]
struct First(u32);

impl OfLane for First {
    #[inline(always)]
    fn of(self, cell: u32, _: [u32; 2]) -> u32 {
        // The last cell of n = 2³² − 1 does not wrap either.
        (u64::from(cell) << 24).div_ceil(u64::from(self.0)) as u32
    }
}
