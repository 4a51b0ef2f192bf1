//! Powers.

use super::exponential::{nearest_integer, scaled, small_exp2};
use super::logarithm::{first_bits, log2_parts};
use super::real::Real;

/// Returns x^y for x ≥ 0, where −0 counts as 0; NaN for x < 0.
///
/// The error is below 1.25 + |y|/12 ulp, and nowhere above 24 ulp. As in IEEE 754, 1^y and x^0 are 1 even if the other
/// number is NaN.
#[inline(always)]
pub fn powf<R: Real>(x: R, y: R) -> R {
    let one = R::splat(1.0);
    let (log, [first, rest]) = log2_parts(x);
    // y·log2 x as the exact product of the leading bits plus the rest.
    let leading = first_bits(y);
    let product = leading * first;
    let rest = (y - leading) * first + y * rest;
    let (n, shifted) = nearest_integer(product + rest);
    let power = scaled(small_exp2((product - n) + rest), shifted);
    // Beyond the range of f32 the power is 0 or infinite; 0·∞ is NaN.
    let t = y * log;
    let inside = t.abs().lt(R::splat(151.0));
    let limit = R::select(R::splat(0.0).lt(t), R::splat(f32::INFINITY), t);
    let limit = R::select(t.lt(R::splat(0.0)), R::splat(0.0), limit);
    let value = R::select(inside, power, limit);
    R::select(x.eq(one) | y.eq(R::splat(0.0)), one, value)
}
