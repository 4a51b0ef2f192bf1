//! Inverse trigonometric functions. Arcsine and arccosine are reduced as in fdlibm [Sun 1993].

use super::by_lane::replace_where;
use super::polynomial::polynomial;
use super::real::{Real, Word};

/// π/4 in two parts, of which the first has 22 bits, so that its products with 0 to 4 are exact.
const QUARTER_PI: [f32; 2] = [f32::from_bits(0x3f49_0fd8), 0.00000015695824];

/// (atan t − t) / t³ in powers of t², for t ≤ ½; relative error of the arctangent 6e-9.
const ARCTANGENT: [f32; 5] = [-0.3333323, 0.19994085, -0.14173456, 0.101530984, -0.051217962];

/// (asin s − s) / s³ in powers of s², for s ≤ ½; relative error of the arcsine 6e-9.
const ARCSINE: [f32; 5] = [0.16666754, 0.07495277, 0.045471452, 0.024178796, 0.0421625];

/// 2^−100 and 2^100: where the larger of two arguments lies outside, or is NaN, `libm` computes their arctangent.
const RANGE: [f32; 2] = [f32::from_bits(27 << 23), f32::from_bits(227 << 23)];

/// Returns the angle of the vector (x, y) to the x axis, in −π..π radians. The error is below 1.8 ulp.
///
/// The signs of zeros count as in IEEE 754: atan2(±0, −1) = ±π. Where the larger of |x| and |y| lies outside of
/// 2^−100..2^100, and for (0, 0) and NaN, lanes are computed one by one by `libm`, which is slow.
#[inline(always)]
pub fn atan2<R: Real>(y: R, x: R) -> R {
    let (a, b) = (y.abs(), x.abs());
    let steep = b.lt(a);
    let (low, high) = (R::select(steep, b, a), R::select(steep, a, b));
    // atan(low / high), or π/4 plus the arctangent of a small number if that exceeds atan ½.
    let wide = (high * R::splat(0.5)).lt(low);
    let t = R::select(wide, low - high, low) / R::select(wide, low + high, high);
    let z = t * t;
    let atan = t + t * z * polynomial(z, ARCTANGENT);
    // The angle is k·π/4 ± atan: from the nearest axis, or from the diagonal beside it.
    let left = x.to_bits() & R::Word::splat(0x8000_0000);
    let away = left ^ R::Word::select(steep, R::Word::splat(0x8000_0000), R::Word::splat(0));
    let axis = R::select(left.eq(R::Word::splat(0)), R::splat(0.0), R::splat(4.0));
    let axis = R::select(steep, R::splat(2.0), axis);
    let step = R::select(wide, R::splat(1.0), R::splat(0.0));
    let k = axis + R::from_bits(step.to_bits() ^ away);
    let rest = R::from_bits(atan.to_bits() ^ away) + k * R::splat(QUARTER_PI[1]);
    let angle = (k * R::splat(QUARTER_PI[0]) + rest).copysign(y);
    let inside = high.ge(R::splat(RANGE[0])) & high.le(R::splat(RANGE[1])) & a.eq(a) & b.eq(b);
    replace_where(!inside, angle, y, x, libm::atan2f)
}

/// Returns whether |x| > ½, and asin |x|, or ½·acos |x| if |x| > ½, as a sum of two; NaN for |x| > 1.
#[inline(always)]
fn small_arcsine<R: Real>(x: R) -> (R::Mask, R, R) {
    let a = x.abs();
    let wide = R::splat(0.5).lt(a);
    let z = R::select(wide, (R::splat(1.0) - a) * R::splat(0.5), a * a);
    let s = R::select(wide, z.sqrt(), a);
    (wide, s, s * z * polynomial(z, ARCSINE))
}

/// Returns the angle in −π/2..π/2 radians whose sine is `x`; NaN for |x| > 1. The error is below 1.2 ulp.
#[inline(always)]
pub fn asin<R: Real>(x: R) -> R {
    let (wide, s, rest) = small_arcsine(x);
    let (half_pi, twice) = (R::splat(2.0 * QUARTER_PI[0]), s + s);
    let main = half_pi - twice;
    let lost = (half_pi - main) - twice;
    let steep = main + (R::splat(2.0 * QUARTER_PI[1]) - (rest + rest) + lost);
    R::select(wide, steep, s + rest).copysign(x)
}

/// Returns the angle in 0..π radians whose cosine is `x`; NaN for |x| > 1. The error is below 1.2 ulp.
#[inline(always)]
pub fn acos<R: Real>(x: R) -> R {
    let (wide, s, rest) = small_arcsine(x);
    let p = s + rest;
    // k·π/4 minus the arcsine, or plus and minus twice the angle.
    let left = x.lt(R::splat(0.0));
    let k = R::select(wide, R::select(left, R::splat(4.0), R::splat(0.0)), R::splat(2.0));
    let p = R::select(wide, p + p, -p);
    let p = R::select(left, -p, p);
    k * R::splat(QUARTER_PI[0]) + (p + k * R::splat(QUARTER_PI[1]))
}
