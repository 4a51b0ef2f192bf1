//! Sine and cosine.

use super::by_lane::replace_where;
use super::polynomial::polynomial;
use super::real::{Real, Word};
use std::f32::consts::FRAC_2_PI;

/// Largest |x| for which the reduction below is exact enough. Beyond it, and for infinities and NaN, lanes are computed
/// by `libm`.
const LARGEST: f32 = 8192.0;

/// 1.5·2²³: adding it to a number of less than 2²² leaves the nearest integer in the lowest bits of the sum.
const SHIFT: f32 = 12_582_912.0;

/// π/2 in three parts. The first two have 11 bits, so that their products with integers below 2¹³ are exact
/// [Cody & Waite 1980].
const HALF_PI: [f32; 3] = [1.5703125, 0.0004837513, 0.0000000754979];

/// (sin r − r) / r³ in powers of r², for |r| ≤ π/4; relative error of the sine 4e-9.
const SINE: [f32; 3] = [-0.16666655, 0.00833219, -0.00019518395];

/// (cos r − 1 + r²/2) / r⁴ in powers of r², for |r| ≤ π/4; error of the cosine 1e-10.
const COSINE: [f32; 3] = [0.041666646, -0.0013887312, 0.000024432737];

/// Sines and cosines of |x| after subtraction of a multiple q of π/2, and q modulo 4 in the lowest bits of a word.
#[inline(always)]
fn reduced<R: Real>(x: R) -> (R, R, R::Word) {
    let x = x.abs();
    let shifted = x * R::splat(FRAC_2_PI) + R::splat(SHIFT);
    let n = shifted - R::splat(SHIFT);
    // The remainder is r + c, where c is the rounding error of r.
    let exact = (x - n * R::splat(HALF_PI[0])) - n * R::splat(HALF_PI[1]);
    let rest = n * R::splat(HALF_PI[2]);
    let r = exact - rest;
    let c = (exact - r) - rest;
    let z = r * r;
    let half = z * R::splat(0.5);
    let w = R::splat(1.0) - half;
    let sin = r + (r * z * polynomial(z, SINE) + c * w);
    let cos = w + (((R::splat(1.0) - w) - half) + (z * z * polynomial(z, COSINE) - r * c));
    (sin, cos, shifted.to_bits())
}

/// Selects the sine of the whole angle from those of the remainder; `q` is the number of quarter turns.
#[inline(always)]
fn turned<R: Real>(sin: R, cos: R, q: R::Word) -> R {
    let one = R::Word::splat(1);
    let value = R::select((q & one).eq(one), cos, sin);
    let sign = (q & R::Word::splat(2)) << 30;
    R::from_bits(value.to_bits() ^ sign)
}

/// Changes the sign of `y` if `x` is negative.
#[inline(always)]
fn odd<R: Real>(y: R, x: R) -> R {
    R::from_bits(y.to_bits() ^ (x.to_bits() & R::Word::splat(0x8000_0000)))
}

#[inline(always)]
fn outside<R: Real>(x: R) -> R::Mask {
    !x.abs().le(R::splat(LARGEST))
}

/// Returns the sine of `x` in radians. The error is below 5e-8, and below 0.8 ulp for |x| ≤ 2π. Beyond |x| = 8192, and
/// for infinities and NaN, lanes are computed one by one by `libm`, which is slow.
#[inline(always)]
pub fn sin<R: Real>(x: R) -> R {
    let (sin, cos, q) = reduced(x);
    let value = odd(turned(sin, cos, q), x);
    replace_where(outside(x), value, x, x, libm_sin)
}

/// Returns the cosine of `x` in radians; domain and errors are those of [`sin`].
#[inline(always)]
pub fn cos<R: Real>(x: R) -> R {
    let (sin, cos, q) = reduced(x);
    let value = turned(sin, cos, q.wrapping_add(R::Word::splat(1)));
    replace_where(outside(x), value, x, x, libm_cos)
}

/// Returns the sine and the cosine of `x` in radians: the same bits as [`sin`] and [`cos`], in little more than the time
/// of one of them.
#[inline(always)]
pub fn sin_cos<R: Real>(x: R) -> (R, R) {
    let (sin, cos, q) = reduced(x);
    let (s, c) = (odd(turned(sin, cos, q), x), turned(sin, cos, q.wrapping_add(R::Word::splat(1))));
    let outside = outside(x);
    (replace_where(outside, s, x, x, libm_sin), replace_where(outside, c, x, x, libm_cos))
}

fn libm_sin(x: f32, _: f32) -> f32 {
    libm::sinf(x)
}

fn libm_cos(x: f32, _: f32) -> f32 {
    libm::cosf(x)
}
