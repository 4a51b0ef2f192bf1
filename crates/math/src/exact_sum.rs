//! Exact sums of single-precision numbers, independent of the order of summation.

/// A sum of finite `f32` values without rounding, a fixed-point superaccumulator [Kulisch 2013]: any order of additions
/// gives the same value. At most 2⁶³ values may be added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ExactSum {
    /// A two's-complement integer in units of 2⁻¹⁴⁹, the smallest positive `f32`, least significant limb first. The
    /// largest `f32` is below 2²⁷⁷ of them, so 6 limbs leave room for 2¹⁰⁶ additions.
    limbs: [u64; 6],
    /// Number of values that were not finite.
    bad: u64,
}

impl ExactSum {
    /// Adds a value. One that is not finite makes [`Self::value`] NaN.
    pub fn add(&mut self, x: f32) {
        if !x.is_finite() {
            self.bad += 1;
            return;
        }
        let bits = x.to_bits();
        let exponent = (bits >> 23) & 0xff;
        let mantissa = u64::from(bits & 0x7f_ffff) | if exponent > 0 { 1 << 23 } else { 0 };
        let shift = exponent.max(1) - 1;
        let wide = u128::from(mantissa) << (shift % 64);
        let mut term = [0; 6];
        term[shift as usize / 64] = wide as u64;
        term[shift as usize / 64 + 1] = (wide >> 64) as u64;
        if x.is_sign_negative() {
            term = negated(term);
        }
        self.limbs = sum(self.limbs, term);
    }

    /// Adds all values of another sum.
    pub fn merge(&mut self, other: &Self) {
        self.limbs = sum(self.limbs, other.limbs);
        self.bad += other.bad;
    }

    /// The sum, with a relative rounding error of a few 2⁻⁵³. NaN if a value was not finite.
    pub fn value(&self) -> f64 {
        if self.bad > 0 {
            return f64::NAN;
        }
        let negative = self.limbs[5] >> 63 == 1;
        let limbs = if negative { negated(self.limbs) } else { self.limbs };
        // Most significant limb first, so that the largest terms are added first; 2⁻¹⁴⁹ and 2¹⁷¹ are normal f64.
        let scaled = limbs.iter().rev().fold(0.0, |sum: f64, limb| sum * TWO_64 + *limb as f64);
        if negative { -scaled * UNIT } else { scaled * UNIT }
    }
}

/// 2⁶⁴.
const TWO_64: f64 = 18_446_744_073_709_551_616.0;

/// 2⁻¹⁴⁹.
const UNIT: f64 = f64::from_bits((1023 - 149) << 52);

fn sum(a: [u64; 6], b: [u64; 6]) -> [u64; 6] {
    let mut carry = false;
    let mut out = [0; 6];
    for (o, (a, b)) in out.iter_mut().zip(a.into_iter().zip(b)) {
        let (partial, first) = a.overflowing_add(b);
        let (total, second) = partial.overflowing_add(u64::from(carry));
        (*o, carry) = (total, first || second);
    }
    out
}

fn negated(a: [u64; 6]) -> [u64; 6] {
    sum(a.map(|limb| !limb), [1, 0, 0, 0, 0, 0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: impl IntoIterator<Item = f32>) -> ExactSum {
        let mut sum = ExactSum::default();
        values.into_iter().for_each(|x| sum.add(x));
        sum
    }

    #[test]
    fn single_values_and_integers_are_exact() {
        for x in [0.0, 1.0, -1.5, f32::MAX, -f32::MAX, f32::MIN_POSITIVE, 1e-45, -1e-45, 0.1, 1e30, -3e-39] {
            assert_eq!(of([x]).value(), f64::from(x), "{x}");
        }
        assert_eq!(of((1..=100_000).map(|i| i as f32)).value(), 5_000_050_000.0);
        assert_eq!(of([f32::MAX; 1000]).value(), 1000.0 * f64::from(f32::MAX));
    }

    #[test]
    fn no_digit_is_lost_and_the_order_does_not_matter() {
        let values = [1e30, 1.0, -1e30, 1e-30, f32::MAX, -f32::MAX, -1e-30, 0.25];
        let forward = of(values);
        assert_eq!(forward.value(), 1.25);
        let (mut halves, second) =
            (of(values[4..].iter().rev().copied()), of(values[..4].iter().rev().copied()));
        halves.merge(&second);
        assert_eq!(halves, forward);
    }

    #[test]
    fn values_that_are_not_finite_are_remembered() {
        assert!(of([1.0, f32::INFINITY, 2.0]).value().is_nan() && of([f32::NAN]).value().is_nan());
    }
}
