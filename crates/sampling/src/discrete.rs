//! Discrete distributions with given weights. Sampling inverts the cumulative distribution, so that stratified u stay
//! stratified (an alias table would shuffle them). A guide table gives the first index for each of about n equal parts of
//! u [Chen & Asau 1974], and the few indices of a part are searched by halves.

use dapple_math::lanes::{Mask, Real, Word};

/// A distribution over n indices with probabilities proportional to their weights.
#[derive(Clone, Debug)]
pub struct Discrete {
    /// Numbers 2i and 2i + 1 are the two parts of the probability of an index below i (see [`parts`]). There are n + 1
    /// pairs, and the last is exactly 1.
    edges: Vec<f32>,
    /// Entry g of m + 1 is the index of u = g/m, and the last entry the last index of positive probability. m is a power of two.
    guide: Vec<u32>,
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

/// Largest number of parts of the guide table, so that the part of a u in f32 is found exactly.
const MOST_PARTS: usize = 1 << 23;

impl Discrete {
    /// Creates the distribution. It is None when no weight is positive, when a weight is negative or not finite, when
    /// the sum overflows, or when there are 2³⁰ weights or more.
    pub fn new(weights: &[f64]) -> Option<Self> {
        if weights.len() >= 1 << 30 || weights.iter().any(|w| !w.is_finite() || *w < 0.0) {
            return None;
        }
        let sum: f64 = weights.iter().sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return None;
        }
        // Rounding must not leave a gap after the last index with a positive weight.
        let last = weights.iter().rposition(|w| *w > 0.0)?;
        let mut edges = Vec::with_capacity(2 * weights.len() + 2);
        let mut running = 0.0;
        edges.extend(parts(0.0));
        for (i, w) in weights.iter().enumerate() {
            running += w;
            edges.extend(parts(if i >= last { 1.0 } else { (running / sum).min(1.0) }));
        }
        let parts = weights.len().next_power_of_two().min(MOST_PARTS);
        let mut index = 0;
        let guide = (0..=parts).map(|g| {
            let u = (g as f32 / parts as f32).min(LARGEST);
            while edges[2 * index + 2] <= u {
                index += 1;
            }
            index as u32
        });
        let mut guide: Vec<u32> = guide.collect();
        guide[parts] = last as u32;
        Some(Self { edges, guide })
    }

    /// Samples an index by `u` in [0,1). An index of weight 0 is never sampled.
    #[inline]
    pub fn sample(&self, u: f32) -> Choice {
        let choice = self.sample_lanes(u);
        Choice { index: choice.index as usize, pmf: choice.pmf, u: choice.u }
    }

    /// Samples an index per lane, as [`Discrete::sample`] does.
    #[inline(always)]
    pub fn sample_lanes<R: Real>(&self, u: R) -> Choicex<R> {
        // NaN becomes 0.
        let u = u.max(R::splat(0.0)).min(R::splat(LARGEST));
        let (one, parts) = (R::Word::splat(1), R::splat((self.guide.len() - 1) as f32));
        let part = (u * parts).to_int();
        let mut low = R::Word::gather(&self.guide, part);
        let mut high = R::Word::gather(&self.guide, part.wrapping_add(one));
        // The first bin whose upper edge is above u, which is never a bin of zero width.
        loop {
            let open = low.lt(high);
            if !open.any() {
                break;
            }
            let middle = low.wrapping_add(high) >> 1;
            let edge = R::gather(&self.edges, (middle << 1).wrapping_add(R::Word::splat(2)));
            let is_above = edge.le(u);
            low = R::Word::select(open & is_above, middle.wrapping_add(one), low);
            high = R::Word::select(open & !is_above, middle, high);
        }
        let [edge, rest, pmf] = self.bin(low);
        let within = ((u - edge) - rest) / pmf;
        let u = within.max(R::splat(0.0)).min(R::splat(LARGEST));
        Choicex { index: low, pmf, u }
    }

    /// Returns the two parts of the lower edge of an index and its probability.
    #[inline(always)]
    fn bin<R: Real>(&self, index: R::Word) -> [R; 3] {
        let at = index << 1;
        let number = |i| at.wrapping_add(R::Word::splat(i));
        let (low, low_rest) = (R::gather(&self.edges, at), R::gather(&self.edges, number(1)));
        let (high, high_rest) = (R::gather(&self.edges, number(2)), R::gather(&self.edges, number(3)));
        [low, low_rest, (high - low) + (high_rest - low_rest)]
    }

    /// Samples as [`Discrete::sample`] does, by 32 random bits, for more than 2^24 indices.
    pub fn sample_bits(&self, bits: u32) -> Choice {
        let u = f64::from(bits) / 4_294_967_296.0;
        let part = (u * (self.guide.len() - 1) as f64) as usize;
        let (mut index, mut end) = (self.guide[part] as usize, self.guide[part + 1] as usize);
        while index < end {
            let middle = (index + end) / 2;
            if self.edge(middle + 1) <= u {
                index = middle + 1;
            } else {
                end = middle;
            }
        }
        let within = (u - self.edge(index)) / self.probability(index);
        Choice { index, pmf: self.pmf(index), u: (within as f32).clamp(0.0, LARGEST) }
    }

    /// Returns the probability that `sample` returns `index`; 0 if out of range. A weight below about 1e-14 of the sum
    /// counts as 0.
    #[inline]
    pub fn pmf(&self, index: usize) -> f32 {
        if index >= self.len() { 0.0 } else { self.bin::<f32>(index as u32)[2] }
    }

    /// Returns the probability that `sample` returns each lane's index, which is below the number of indices.
    #[inline(always)]
    pub fn pmf_lanes<R: Real>(&self, index: R::Word) -> R {
        self.bin(index)[2]
    }

    pub(crate) fn probability(&self, index: usize) -> f64 {
        if index >= self.len() { 0.0 } else { self.edge(index + 1) - self.edge(index) }
    }

    /// Returns the probability of an index below `index` ≤ n.
    fn edge(&self, index: usize) -> f64 {
        f64::from(self.edges[2 * index]) + f64::from(self.edges[2 * index + 1])
    }

    /// Returns the number of indices.
    pub fn len(&self) -> usize {
        self.edges.len() / 2 - 1
    }

    /// Returns false, because an empty distribution cannot be created.
    pub fn is_empty(&self) -> bool {
        false
    }
}

/// The largest number below 1.
const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;

/// Splits 0 ≤ x ≤ 1 into the smallest f32 that is not below it, and the rest, which is not positive. A u in f32 is below
/// x exactly if it is below the first part. Their sum is x to within 2⁻⁴⁸ of it.
fn parts(x: f64) -> [f32; 2] {
    let near = x as f32;
    let first = if f64::from(near) < x { near.next_up() } else { near };
    // Even after rounding, the sum stays above the f32 before the first part, so that no bin that is found is empty.
    let least = f64::from(first.next_down()) - f64::from(first);
    let rest = (x - f64::from(first)) as f32;
    [first, rest.max((least as f32).next_up()).min(0.0)]
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
        assert!((0..=n).all(|i| d.edge(i as usize) == f64::from(i) / f64::from(n)));
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
        assert!((d.probability(12_345_678) - exact).abs() < 1e-12);
        let tries = 1u32 << 16;
        let hits = (0..tries).filter(|i| d.sample_bits(i << 16).index == 12_345_678).count();
        assert!((hits as f64 - exact * f64::from(tries)).abs() <= 1.0);
    }
}
