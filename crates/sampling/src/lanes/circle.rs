//! Points of the unit circle, by fractions of the circle instead of angles, which makes their reduction exact.

use dapple_math::lanes::{Real, Word};
use std::f32::consts::FRAC_PI_4;

/// sin(πx/4)/x in powers of x², for |x| ≤ 1; error 3e-8.
const SINE: [f32; 4] = [FRAC_PI_4, -0.080_745_44, 0.002_490_007, -0.000_035_954_29];

/// (cos(πx/4) − 1)/x² in powers of x², for |x| ≤ 1; error 1e-8.
const COSINE: [f32; 4] = [-0.308_425_13, 0.015_854_338, -0.000_325_961_4, 0.000_003_541_953];

/// Returns sine and cosine of `x` eighths of the circle, |x| ≤ 1, with errors below 1.2e-7.
#[inline(always)]
pub fn eighth<R: Real>(x: R) -> (R, R) {
    let z = x * x;
    (x * polynomial(z, SINE), R::splat(1.0) + z * polynomial(z, COSINE))
}

#[inline(always)]
fn polynomial<R: Real>(z: R, [a, b, c, d]: [f32; 4]) -> R {
    R::splat(a) + z * (R::splat(b) + z * (R::splat(c) + z * R::splat(d)))
}

/// 1.5·2²³: adding it to a number of less than 2²² leaves the nearest integer in the lowest bits of the sum.
const SHIFT: f32 = 12_582_912.0;

/// Returns sine and cosine of `u` circles, |u| ≤ 2²⁰, with errors below 1.2e-7.
#[inline(always)]
pub fn circle<R: Real>(u: R) -> (R, R) {
    let quarters = u * R::splat(4.0);
    let shifted = quarters + R::splat(SHIFT);
    let rest = quarters - (shifted - R::splat(SHIFT));
    let (sin, cos) = eighth(rest + rest);
    let quarter = shifted.to_bits();
    let (one, two) = (R::Word::splat(1), R::Word::splat(2));
    let is_odd = (quarter & one).eq(one);
    let (sign_sin, sign_cos) = ((quarter & two) << 30, (quarter.wrapping_add(one) & two) << 30);
    let (sin, cos) = (R::select(is_odd, cos, sin), R::select(is_odd, sin, cos));
    (R::from_bits(sin.to_bits() ^ sign_sin), R::from_bits(cos.to_bits() ^ sign_cos))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn errors_are_as_stated() {
        let mut worst: f64 = 0.0;
        for i in -200_000..=200_000 {
            let x = i as f32 / 200_000.0;
            let angle = f64::from(x) * TAU / 8.0;
            let (s, c) = eighth(x);
            worst = worst.max((f64::from(s) - angle.sin()).abs()).max((f64::from(c) - angle.cos()).abs());
            let angle = f64::from(x * 3.0) * TAU;
            let (s, c) = circle(x * 3.0);
            worst = worst.max((f64::from(s) - angle.sin()).abs()).max((f64::from(c) - angle.cos()).abs());
        }
        assert!(worst < 1.2e-7, "{worst:e}");
        assert_eq!([circle(0.25f32), circle(0.5)], [(1.0, 0.0), (0.0, -1.0)]);
    }
}
