//! Polynomials.

use super::real::Real;

/// Evaluates `c[0] + c[1]·x + c[2]·x² + …`, from the last coefficient on.
#[inline(always)]
pub fn polynomial<R: Real, const N: usize>(x: R, c: [f32; N]) -> R {
    let mut sum = R::splat(c[N - 1]);
    for i in (0..N - 1).rev() {
        sum = sum * x + R::splat(c[i]);
    }
    sum
}
