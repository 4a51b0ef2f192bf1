//! Weights of multiple importance sampling (MIS) over numbers; [`crate::mis`] has those of single densities.

use dapple_math::lanes::Real;

/// Returns the MIS weight of strategy a against b by the power heuristic with β = 2 [Veach 1997, §9.2.2]. If the numbers
/// of samples differ, the arguments must be count·pdf. w(0, ·) = 0; two infinite densities have a weight of ½ each;
/// w(a,b) + w(b,a) = 1 unless both are 0. A strategy whose density is NaN counts as absent.
#[inline(always)]
pub fn power<R: Real>(pdf_a: R, pdf_b: R) -> R {
    let (ratio, a_is_larger) = ratio(pdf_a, pdf_b);
    weight(pdf_a, pdf_b, ratio * ratio, a_is_larger)
}

/// Returns the MIS weight by the balance heuristic, with the same arguments and special cases as [`power`].
#[inline(always)]
pub fn balance<R: Real>(pdf_a: R, pdf_b: R) -> R {
    let (ratio, a_is_larger) = ratio(pdf_a, pdf_b);
    weight(pdf_a, pdf_b, ratio, a_is_larger)
}

/// Returns the smaller density divided by the larger, so that nothing overflows, and whether a is the larger.
#[inline(always)]
fn ratio<R: Real>(a: R, b: R) -> (R, R::Mask) {
    let a_is_larger = b.le(a);
    (R::select(a_is_larger, b, a) / R::select(a_is_larger, a, b), a_is_larger)
}

/// Returns 1/(1 + r) for a the larger, r/(1 + r) otherwise, and the special cases.
#[inline(always)]
fn weight<R: Real>(a: R, b: R, r: R, a_is_larger: R::Mask) -> R {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let w = R::select(a_is_larger, one, r) / (one + r);
    let infinite = R::splat(f32::INFINITY);
    let w = R::select(a.eq(infinite) & b.eq(infinite), R::splat(0.5), w);
    let w = R::select(b.gt(zero), w, one);
    R::select(a.gt(zero), w, zero)
}
