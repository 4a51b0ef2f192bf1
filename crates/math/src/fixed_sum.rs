//! Sums in fixed point, independent of the order of summation.

use glam::DVec3;

/// A sum of numbers of moderate size, each rounded towards zero to a multiple of 2⁻⁶⁴ and limited to ±2³¹: any order
/// of additions gives the same value. At most 2³² numbers may be added. Single-precision numbers of at least 2⁻⁴⁰ keep
/// all of their digits. A value that is not a number adds zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FixedSum(i128);

impl FixedSum {
    /// Adds a number.
    #[inline]
    pub fn add(&mut self, x: f64) {
        self.0 = self.0.wrapping_add((x.clamp(-LARGEST, LARGEST) * TWO_64) as i128);
    }

    /// Adds all numbers of another sum.
    pub fn merge(&mut self, other: &Self) {
        self.0 = self.0.wrapping_add(other.0);
    }

    /// The sum, rounded to f64.
    pub fn value(&self) -> f64 {
        self.0 as f64 / TWO_64
    }
}

/// A sum of vectors, each component as in [`FixedSum`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FixedVector([FixedSum; 3]);

impl FixedVector {
    /// Adds a vector.
    #[inline]
    pub fn add(&mut self, v: DVec3) {
        self.0.iter_mut().zip(v.to_array()).for_each(|(sum, x)| sum.add(x));
    }

    /// Adds all vectors of another sum.
    pub fn merge(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(sum, other)| sum.merge(other));
    }

    /// The sum, rounded to f64.
    pub fn value(&self) -> DVec3 {
        DVec3::from_array(self.0.map(|sum| sum.value()))
    }
}

/// 2³¹.
const LARGEST: f64 = 2_147_483_648.0;

/// 2⁶⁴.
const TWO_64: f64 = 18_446_744_073_709_551_616.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moderate_numbers_are_exact() {
        for x in [0.0, 1.0, -1.5, 0.1f32, 1e-12, -3e-9, 123.456, LARGEST as f32] {
            let mut sum = FixedSum::default();
            (0..3).for_each(|_| sum.add(f64::from(x)));
            assert_eq!(sum.value(), 3.0 * f64::from(x), "{x}");
        }
    }

    #[test]
    fn the_order_does_not_matter() {
        let numbers: Vec<f64> = (0..1000).map(|i| libm::exp(0.02 * f64::from(i % 997)) - 1e3).collect();
        let of = |numbers: &mut dyn Iterator<Item = &f64>| {
            let mut sum = FixedSum::default();
            numbers.for_each(|x| sum.add(*x));
            sum
        };
        let forward = of(&mut numbers.iter());
        assert_eq!(of(&mut numbers.iter().rev()), forward);
        let (mut last, first) = (of(&mut numbers[300..].iter()), of(&mut numbers[..300].iter()));
        last.merge(&first);
        assert_eq!(last, forward);
        assert!((forward.value() / numbers.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let mut vector = FixedVector::default();
        numbers.iter().for_each(|x| vector.add(DVec3::new(*x, 1.0, -x)));
        assert_eq!(vector.value(), DVec3::new(forward.value(), 1000.0, -forward.value()));
    }

    #[test]
    fn no_number_overflows() {
        let mut sum = FixedSum::default();
        [f64::INFINITY, f64::MAX, f64::NAN, 1.0, -1e300, f64::NEG_INFINITY].iter().for_each(|x| sum.add(*x));
        assert_eq!(sum.value(), 1.0);
    }
}
