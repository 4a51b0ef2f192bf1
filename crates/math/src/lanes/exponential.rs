//! Exponential functions.

use super::polynomial::polynomial;
use super::real::{Real, Word};
use std::f32::consts::LOG2_E;

/// 1.5·2²³, as in the sine: the sum with a small number holds the nearest integer in its lowest bits.
const SHIFT: f32 = 12_582_912.0;

/// ln 2 in two parts, of which the first has 15 bits [Cody & Waite 1980].
pub const LN_2: [f32; 2] = [0.69314575, 0.0000014286068];

/// (e^r − 1 − r) / r² in powers of r, for |r| ≤ ½·ln 2; relative error of the exponential 4e-9.
const EXPONENTIAL: [f32; 5] = [0.5, 0.16666515, 0.041666456, 0.008369243, 0.0013935775];

/// (2^r − 1) / r in powers of r, for |r| ≤ ½; relative error of the power 4e-9.
const POWER: [f32; 6] =
    [std::f32::consts::LN_2, 0.2402265, 0.05550358, 0.009618077, 0.0013391643, 0.00015456358];

/// Returns the integer nearest to a number of less than 2²², as a number and as a shifted word, which [`scaled`] takes.
#[inline(always)]
pub fn nearest_integer<R: Real>(x: R) -> (R, R::Word) {
    let shifted = x + R::splat(SHIFT);
    (shifted - R::splat(SHIFT), shifted.to_bits())
}

/// Returns 2^r for |r| ≤ ½.
#[inline(always)]
pub fn small_exp2<R: Real>(r: R) -> R {
    R::splat(1.0) + r * polynomial(r, POWER)
}

/// Returns x·2ⁿ for −200 ≤ n ≤ 200, rounded once, where `shifted` holds n.
#[inline(always)]
pub fn scaled<R: Real>(x: R, shifted: R::Word) -> R {
    // In two steps of about n/2, because 2ⁿ itself may lie beyond the range of f32.
    let zero = SHIFT.to_bits();
    let half = (shifted >> 1).wrapping_sub(R::Word::splat(zero >> 1));
    let other = shifted.wrapping_sub(half).wrapping_sub(R::Word::splat(zero));
    x * power_of_two(half) * power_of_two(other)
}

/// Returns 2ⁿ for −126 ≤ n ≤ 127.
#[inline(always)]
fn power_of_two<R: Real>(n: R::Word) -> R {
    R::from_bits(n.wrapping_add(R::Word::splat(127)) << 23)
}

/// Holds `x` between two bounds, and leaves NaN.
#[inline(always)]
fn held<R: Real>(x: R, low: f32, high: f32) -> R {
    R::splat(low).max(R::splat(high).min(x))
}

/// Returns e^x. The error is below 1 ulp, for subnormal results too; results beyond the range of f32 are 0 or infinite.
#[inline(always)]
pub fn exp<R: Real>(x: R) -> R {
    let x = held(x, -104.0, 89.0);
    let (n, shifted) = nearest_integer(x * R::splat(LOG2_E));
    // The remainder is r + c, where c is the rounding error of r.
    let exact = x - n * R::splat(LN_2[0]);
    let rest = n * R::splat(LN_2[1]);
    let r = exact - rest;
    let c = (exact - r) - rest;
    let e = R::splat(1.0) + (r + (r * r * polynomial(r, EXPONENTIAL) + c));
    scaled(e, shifted)
}

/// Returns 2^x. The error is below 1.2 ulp; integers give exact results. Results beyond the range of f32 are 0 or
/// infinite.
#[inline(always)]
pub fn exp2<R: Real>(x: R) -> R {
    let x = held(x, -151.0, 129.0);
    let (n, shifted) = nearest_integer(x);
    scaled(small_exp2(x - n), shifted)
}
