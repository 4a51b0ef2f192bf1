//! Discrete distributions with given weights. Sampling inverts the cumulative distribution, so that stratified u stay
//! stratified (an alias table would shuffle them). A guide table makes the number of steps nearly independent of the
//! number of indices.

use crate::table::{LARGEST, Table};
use dapple_math::lanes::{Real, Word};

/// A distribution over n indices with probabilities proportional to their weights.
#[derive(Clone, Debug)]
pub struct Discrete {
    table: Table,
}

/// A sample of a [`Discrete`] distribution.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// The sampled index.
    pub index: usize,
    /// The probability of the index.
    pub pmf: f32,
    /// The input `u`, rescaled to [0,1) within the interval of the index.
    pub u: f32,
}

/// Samples of a [`Discrete`] distribution, one per lane.
#[derive(Clone, Copy, Debug)]
pub struct Choicex<R: Real> {
    /// The sampled index.
    pub index: R::Word,
    /// The probability of the index.
    pub pmf: R,
    /// The input `u`, rescaled to [0,1) within the interval of the index.
    pub u: R,
}

impl Discrete {
    /// Creates the distribution. It is None when no weight is positive, when a weight is negative or not finite, when
    /// the sum overflows, or when there are 2³⁰ weights or more.
    pub fn new(weights: &[f64]) -> Option<Self> {
        if weights.iter().any(|w| !w.is_finite() || *w < 0.0) {
            return None;
        }
        let mut table = Table::new(weights.len(), 1)?;
        table.push(weights)?;
        Some(Self { table })
    }

    /// Samples an index by `u` in [0,1). An index of weight 0 is never sampled.
    #[inline]
    pub fn sample(&self, u: f32) -> Choice {
        let Choicex { index, pmf, u } = self.sample_lanes(u);
        Choice { index: index as usize, pmf, u }
    }

    /// Samples an index per lane, as [`Discrete::sample`] does.
    #[inline(always)]
    pub fn sample_lanes<R: Real>(&self, u: R) -> Choicex<R> {
        let found = self.table.sample(R::Word::splat(0), u);
        Choicex { index: found.index, pmf: found.pmf, u: found.u }
    }

    /// Returns only the index that [`Discrete::sample_lanes`] samples.
    #[inline(always)]
    pub fn index_lanes<R: Real>(&self, u: R) -> R::Word {
        self.table.search(R::Word::splat(0), u.max(R::splat(0.0)).min(R::splat(LARGEST)))
    }

    /// Samples as [`Discrete::sample`] does, by 32 random bits, for more than 2^24 indices.
    pub fn sample_bits(&self, bits: u32) -> Choice {
        let (index, u) = self.table.sample_bits(bits);
        Choice { index, pmf: self.pmf(index), u }
    }

    /// Returns the probability that `sample` returns `index`; 0 if out of range. A weight below about 1e-14 of the sum
    /// counts as 0.
    #[inline]
    pub fn pmf(&self, index: usize) -> f32 {
        if index >= self.len() { 0.0 } else { self.pmf_lanes::<f32>(index as u32) }
    }

    /// Returns the probability of an index per lane, each below the number of indices.
    #[inline(always)]
    pub fn pmf_lanes<R: Real>(&self, index: R::Word) -> R {
        self.table.pmf(R::Word::splat(0), index)
    }

    /// Returns the number of indices.
    pub fn len(&self) -> usize {
        self.table.bins()
    }

    /// Returns false, because an empty distribution cannot be created.
    pub fn is_empty(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weightless_things_are_never_chosen() {
        let d = Discrete::new(&[0.0, 1.0, 0.0, 0.0, 3.0, 0.0]).unwrap();
        for i in 0..100_000 {
            let c = d.sample(i as f32 / 100_000.0);
            assert!(c.index == 1 || c.index == 4);
            assert!((0.0..1.0).contains(&c.u));
        }
        assert_eq!((d.pmf(1), d.pmf(4), d.pmf(0)), (0.25, 0.75, 0.0));
        assert_eq!(d.sample(1.0).index, 4);
    }

    #[test]
    fn u_is_stretched_back() {
        let d = Discrete::new(&[1.0, 1.0, 2.0]).unwrap();
        let c = d.sample(0.375);
        assert_eq!((c.index, c.u), (1, 0.5));
    }

    #[test]
    fn bad_weights_are_refused() {
        for w in [&[][..], &[0.0], &[-1.0, 2.0], &[f64::NAN], &[f64::INFINITY]] {
            assert!(Discrete::new(w).is_none());
        }
    }

    /// docs/science.md, "Tables": with equal weights, bin i contains the 2^7 inputs from i·2^7 on.
    #[test]
    fn all_of_2_to_the_25_bins_can_be_reached() {
        let n = 1u32 << 25;
        let d = Discrete::new(&vec![1.0; n as usize]).unwrap();
        // Every edge is exactly an input; the search is tested for one bin in 101.
        assert!((0..=n).all(|i| d.table.edge(i as usize) == f64::from(i) / f64::from(n)));
        for bin in (0..n).step_by(101) {
            assert_eq!(d.sample_bits(bin << 7).index, bin as usize);
            assert_eq!(d.sample_bits(bin << 7 | 127).index, bin as usize);
        }
        assert_eq!(d.sample_bits(u32::MAX).index, n as usize - 1);
        assert_eq!(d.pmf(77), 1.0 / n as f32);
    }

    /// docs/science.md, "Tables": a sum of ones, which would stall at 2^24 in f32, and one bin of large weight.
    #[test]
    fn a_heavy_bin_among_many_keeps_its_probability() {
        let n = 1usize << 25;
        let mut weights = vec![1.0; n];
        weights[12_345_678] = 1e7;
        let d = Discrete::new(&weights).unwrap();
        let exact = 1e7 / (1e7 + (n - 1) as f64);
        assert!((d.table.edge(12_345_679) - d.table.edge(12_345_678) - exact).abs() < 1e-12);
        let tries = 1u32 << 16;
        let hits = (0..tries).filter(|i| d.sample_bits(i << 16).index == 12_345_678).count();
        assert!((hits as f64 - exact * f64::from(tries)).abs() <= 1.0);
    }
}
