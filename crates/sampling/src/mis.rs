//! Weights of multiple importance sampling (MIS), computed from the ratio of the densities, which does not overflow or
//! underflow for densities of 1e±30.

use crate::lanes::mis;

/// Returns the MIS weight of strategy a against b by the power heuristic with β = 2 [Veach 1997, §9.2.2]. If the
/// numbers of samples differ, the arguments must be count·pdf. w(0, ·) = 0; two infinite densities have a weight of ½
/// each; w(a,b) + w(b,a) = 1 unless both are 0. A strategy whose density is NaN counts as absent.
pub fn power(pdf_a: f32, pdf_b: f32) -> f32 {
    mis::power(pdf_a, pdf_b)
}

/// Returns the MIS weight by the balance heuristic, with the same arguments and special cases as [`power`].
pub fn balance(pdf_a: f32, pdf_b: f32) -> f32 {
    mis::balance(pdf_a, pdf_b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extreme_densities_are_weighed() {
        let inf = f32::INFINITY;
        for (a, b) in
            [(1e20, 1e18), (1e-25, 1e-24), (3e38, 1.0), (inf, 1.0), (1.0, 0.0), (0.3, 0.7), (1e-30, 1e30)]
        {
            let sum = power(a, b) + power(b, a);
            assert!((sum - 1.0).abs() < 1e-6, "{a} {b}: {sum}");
            assert!((balance(a, b) + balance(b, a) - 1.0).abs() < 1e-6);
        }
        assert_eq!(power(0.0, 0.0), 0.0);
        assert_eq!(power(0.0, 1.0), 0.0);
        assert_eq!(power(0.0, f32::NAN), 0.0);
        assert_eq!(power(f32::NAN, 1.0), 0.0);
        assert_eq!(power(1.0, f32::NAN), 1.0);
        assert_eq!(power(inf, inf), 0.5);
        assert_eq!(power(1.0, inf), 0.0);
        assert_eq!(power(inf, 1.0), 1.0);
        assert!((power(1.0, 3.0) - 0.1).abs() < 1e-7);
    }
}
