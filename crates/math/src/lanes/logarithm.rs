//! Logarithms, reduced as in fdlibm [Sun 1993].

use super::exponential::LN_2;
use super::polynomial::polynomial;
use super::real::{Real, Word};

/// (ln((1+s)/(1−s)) − 2s) / s³ in powers of s², for s ≤ (√2 − 1)/(√2 + 1); relative error of
/// the logarithm 2e-9.
const LOGARITHM: [f32; 3] = [0.66666776, 0.39977583, 0.2987084];

/// 1 / ln 2 in two parts, of which the first has 12 bits.
const LOG2_E: [f32; 2] = [1.4423828, 0.0003122284];

/// The logarithm of x > 0, in parts: x = 2ᵏ·(1 + f) with 1 + f in √½..√2, and ln(1 + f) = f − h + g.
struct Parts<R> {
    k: R,
    f: R,
    /// ½·f².
    h: R,
    g: R,
}

#[inline(always)]
fn parts<R: Real>(x: R) -> Parts<R> {
    const ROOT_HALF: u32 = 0x3f35_04f3;
    const ONE: u32 = 0x3f80_0000;
    let tiny = x.lt(R::splat(f32::MIN_POSITIVE));
    let normal = R::select(tiny, x * R::splat(33_554_432.0), x);
    let bits = normal.to_bits().wrapping_add(R::Word::splat(ONE - ROOT_HALF));
    let k = (bits >> 23).int_to_real() - R::select(tiny, R::splat(127.0 + 25.0), R::splat(127.0));
    let bits = (bits & R::Word::splat(0x007f_ffff)).wrapping_add(R::Word::splat(ROOT_HALF));
    let f = R::from_bits(bits) - R::splat(1.0);
    let s = f / (f + R::splat(2.0));
    let z = s * s;
    let h = f * f * R::splat(0.5);
    Parts { k, f, h, g: s * (h + z * polynomial(z, LOGARITHM)) }
}

/// Replaces the logarithm where x is not positive and finite: −∞ at 0, NaN below, ∞ and NaN as they are.
#[inline(always)]
fn total<R: Real>(x: R, log: R) -> R {
    let zero = R::splat(0.0);
    let regular = zero.lt(x) & x.lt(R::splat(f32::INFINITY));
    let limit = R::select(x.lt(zero), R::splat(f32::NAN), x);
    let limit = R::select(x.eq(zero), R::splat(f32::NEG_INFINITY), limit);
    R::select(regular, log, limit)
}

/// Returns the natural logarithm. The error is below 1 ulp. It is −∞ at ±0 and NaN below.
#[inline(always)]
pub fn ln<R: Real>(x: R) -> R {
    let Parts { k, f, h, g } = parts(x);
    let log = k * R::splat(LN_2[0]) + (f - (h - (g + k * R::splat(LN_2[1]))));
    total(x, log)
}

/// Returns the binary logarithm. The error is below 1 ulp, and powers of two give exact results. It is −∞ at ±0 and
/// NaN below.
#[inline(always)]
pub fn log2<R: Real>(x: R) -> R {
    log2_parts(x).0
}

/// Returns the binary logarithm, and for positive and finite x its value in two parts, of which the first has 12 bits;
/// the error of their sum is about 2^−28.
#[inline(always)]
pub fn log2_parts<R: Real>(x: R) -> (R, [R; 2]) {
    let Parts { k, f, g, .. } = parts(x);
    // ½·f² is the exact h of its first bits, and a rest.
    let front = first_bits(f);
    let h = front * front * R::splat(0.5);
    let rest = (f - front) * (f + front) * R::splat(0.5);
    // ln(1 + f) = high + low, where `high` has 12 bits and its product with those of 1 / ln 2 is exact.
    let high = first_bits(f - h);
    let low = ((f - high) - h) + (g - rest);
    let a = high * R::splat(LOG2_E[0]);
    let b = (high + low) * R::splat(LOG2_E[1]) + low * R::splat(LOG2_E[0]);
    // k + a without rounding error [Higham 2002, §4.3]: k is 0 or larger than a.
    let sum = k + a;
    let rest = ((k - sum) + a) + b;
    let log = sum + rest;
    let first = first_bits(log);
    (total(x, log), [first, (sum - first) + rest])
}

/// Clears the last 12 of the 24 bits of a number, so that products of two such numbers are exact.
#[inline(always)]
pub fn first_bits<R: Real>(x: R) -> R {
    R::from_bits(x.to_bits() & R::Word::splat(0xffff_f000))
}
