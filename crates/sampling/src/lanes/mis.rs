//! Weights of multiple importance sampling (MIS) over numbers; [`crate::mis`] has those of single densities.

use dapple_math::lanes::Real;

/// Returns the MIS weight of strategy a against b by the power heuristic with β = 2 [Veach 1997, §9.2.2]. If the numbers
/// of samples differ, the arguments must be count·pdf. w(0, ·) = 0; two infinite densities have a weight of ½ each;
/// w(a,b) + w(b,a) = 1 unless both are 0. A strategy whose density is NaN counts as absent.
#[inline(always)]
pub fn power<R: Real>(pdf_a: R, pdf_b: R) -> R {
    let ratio = ratio(pdf_a, pdf_b);
    weight(pdf_a, ratio * ratio)
}

/// Returns the MIS weight by the balance heuristic, with the same arguments and special cases as [`power`].
#[inline(always)]
pub fn balance<R: Real>(pdf_a: R, pdf_b: R) -> R {
    weight(pdf_a, ratio(pdf_a, pdf_b))
}

/// Returns b/a, 1 for two infinite densities. It overflows where the weight is 0, and underflows where it is 1.
#[inline(always)]
fn ratio<R: Real>(a: R, b: R) -> R {
    // NaN becomes 0.
    let ratio = b.max(R::splat(0.0)) / a;
    R::select(ratio.eq(ratio), ratio, R::splat(1.0))
}

/// Returns 1/(1 + r), or 0 without a density.
#[inline(always)]
fn weight<R: Real>(a: R, r: R) -> R {
    let one = R::splat(1.0);
    R::select(a.gt(R::splat(0.0)), one / (one + r), R::splat(0.0))
}
