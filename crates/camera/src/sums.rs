//! Mean and variance of the samples of a pixel, the same to the last bit however the samples are divided.
//!
//! Sums in floating point depend on the order of additions. The samples of a pixel are therefore summed along a binary
//! tree over their indices: its leaves are the samples, and the node of level k and index i covers the samples
//! i·2ᵏ ≤ s < (i + 1)·2ᵏ. A node whose samples are all known is computed from its two halves, and a node that lacks
//! some of them from those that it has; a half without samples is omitted. The value of every node, and that of the
//! whole tree, is thus a function of the set of samples alone: parts of a render, passes and requests to stop may divide
//! the samples anywhere.
//!
//! Of the complete nodes only the largest are kept, at most two per level for a range of samples, and only one for a
//! number of samples that is a power of two. The error grows with the depth of the tree, which is the logarithm of the
//! number of samples [Higham 2002, §4.2].

use glam::DVec3;
use std::fmt;
use std::ops::Range;

/// Mean and sum of squared deviations from it of some samples, per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PixelMoments {
    /// Mean of the samples.
    pub mean: DVec3,
    /// Sum of the squared deviations of the samples from their mean.
    pub m2: DVec3,
}

impl PixelMoments {
    /// The moments of one sample.
    #[inline]
    pub fn of(sample: DVec3) -> Self {
        Self { mean: sample, m2: DVec3::ZERO }
    }

    /// The moments of two sets of 2^`level` samples each: half of the sum of the means, and δ²·2^`level`/2 in addition
    /// to the squared deviations, with δ the difference of the means. Exact for constants. [Chan 1979]
    #[inline]
    pub fn pair(left: &Self, right: &Self, level: u32) -> Self {
        Self::equal(left, right, half_of_power(level))
    }

    #[inline(always)]
    fn equal(left: &Self, right: &Self, half: f64) -> Self {
        let delta = right.mean - left.mean;
        Self { mean: (left.mean + right.mean) * 0.5, m2: left.m2 + right.m2 + delta * delta * half }
    }

    /// The moments of two sets with the given numbers of samples, of which neither is 0. [Chan 1979]
    pub fn join((left, m): (&Self, u64), (right, n): (&Self, u64)) -> Self {
        let (m, n) = (m as f64, n as f64);
        if m == n {
            return Self::equal(left, right, 0.5 * m);
        }
        let (delta, share) = (right.mean - left.mean, n / (m + n));
        Self { mean: left.mean + delta * share, m2: left.m2 + right.m2 + delta * delta * (m * share) }
    }

    /// The variance of the mean of `n` samples, m2/(n(n − 1)), for independent samples. It is infinite, meaning
    /// unknown, while n < 2.
    pub fn variance_of_mean(&self, n: u64) -> DVec3 {
        match n {
            0 | 1 => DVec3::INFINITY,
            n => self.m2 / n as f64 / (n - 1) as f64,
        }
    }
}

/// 2^(`level` − 1).
#[inline(always)]
fn half_of_power(level: u32) -> f64 {
    f64::from_bits((1022 + u64::from(level)) << 52)
}

/// A complete node of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SumNode {
    /// Logarithm of the number of samples to base 2, at most 63.
    pub level: u32,
    /// Index among the nodes of the level.
    pub index: u64,
    /// Moments of the samples of the node.
    pub moments: PixelMoments,
}

impl SumNode {
    /// Index of the first sample.
    pub fn start(&self) -> u64 {
        self.index << self.level
    }

    /// Index of the last sample.
    pub fn last(&self) -> u64 {
        self.start() + (self.count() - 1)
    }

    /// Number of samples.
    pub fn count(&self) -> u64 {
        1 << self.level
    }
}

/// Number and moments of the samples of disjoint nodes, which are in order of their samples.
pub(crate) fn total(nodes: &[SumNode]) -> (u64, PixelMoments) {
    let [first, .., last] = nodes else {
        return nodes.first().map_or((0, PixelMoments::default()), |node| (node.count(), node.moments));
    };
    // The middle of the smallest node of the tree that contains all of them: the bits above the highest one in which
    // the first and the last sample differ, and that bit.
    let (start, last) = (first.start(), last.last());
    let highest = 63 - (start ^ last).leading_zeros();
    let middle = last >> highest << highest;
    let (left, right) = nodes.split_at(nodes.partition_point(|node| node.start() < middle));
    let ((m, left), (n, right)) = (total(left), total(right));
    (m + n, PixelMoments::join((&left, m), (&right, n)))
}

/// Sums of some of the samples of a pixel, a range or any other set of indices below 2⁶³. The same set gives the same
/// bits, in whatever order and groups its samples were added.
///
/// ```
/// use dapple_camera::SampleSums;
/// use glam::DVec3;
///
/// let part = |samples: std::ops::Range<u64>| {
///     let mut sums = SampleSums::default();
///     samples.for_each(|s| sums.add(s, DVec3::splat(0.1 * s as f64)).unwrap());
///     sums
/// };
/// let mut parts = part(100..256);
/// parts.merge(&part(0..7)).unwrap();
/// parts.merge(&part(7..100)).unwrap();
/// assert_eq!(parts.finish(), part(0..256).finish());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Vec<SumNode>", into = "Vec<SumNode>"))]
pub struct SampleSums {
    /// The largest complete nodes, in order of their samples.
    nodes: Vec<SumNode>,
}

impl SampleSums {
    /// Adds the sample with the given index. Fails, without any change, if it was added already.
    pub fn add(&mut self, index: u64, sample: DVec3) -> Result<(), Overlap> {
        self.insert(SumNode { level: 0, index, moments: PixelMoments::of(sample) })
    }

    /// Adds all samples of another part. Fails, without any change, if the parts have a sample in common.
    pub fn merge(&mut self, other: &Self) -> Result<(), Overlap> {
        let mut both = self.clone();
        other.nodes.iter().try_for_each(|node| both.insert(*node))?;
        *self = both;
        Ok(())
    }

    /// Number and moments of all samples; zeros without samples.
    pub fn finish(&self) -> (u64, PixelMoments) {
        total(&self.nodes)
    }

    /// The smallest range that contains the indices of all samples; none without samples.
    pub fn range(&self) -> Option<Range<u64>> {
        let (first, last) = (self.nodes.first()?, self.nodes.last()?);
        Some(first.start()..last.last() + 1)
    }

    /// The largest complete nodes in order of their samples. They are all that is needed to restore the sums with
    /// [`Self::from_nodes`].
    pub fn nodes(&self) -> &[SumNode] {
        &self.nodes
    }

    /// The sums of the samples of `nodes`, in any order. Fails if two of them have a sample in common, or if the
    /// indices of one are not below 2⁶³.
    pub fn from_nodes(nodes: impl IntoIterator<Item = SumNode>) -> Result<Self, Overlap> {
        let mut sums = Self::default();
        nodes.into_iter().try_for_each(|node| sums.insert(node))?;
        Ok(sums)
    }

    /// The sums of nodes that are the largest complete ones, in order of their samples.
    pub(crate) fn of(nodes: Vec<SumNode>) -> Self {
        Self { nodes }
    }

    fn insert(&mut self, mut node: SumNode) -> Result<(), Overlap> {
        if node.level >= 63 || node.index >= 1 << (63 - node.level) {
            return Err(Overlap { index: u64::MAX });
        }
        let mut at = self.nodes.partition_point(|other| other.start() < node.start());
        if at.checked_sub(1).is_some_and(|before| self.nodes[before].last() >= node.start()) {
            return Err(Overlap { index: node.start() });
        }
        if let Some(after) = self.nodes.get(at).filter(|after| after.start() <= node.last()) {
            return Err(Overlap { index: after.start() });
        }
        loop {
            let (level, sibling) = (node.level, node.index ^ 1);
            let beside = if node.index & 1 == 1 { at.wrapping_sub(1) } else { at };
            let is_sibling = |other: &&SumNode| (other.level, other.index) == (level, sibling);
            let Some(other) = self.nodes.get(beside).filter(is_sibling) else { break };
            let (left, right) = if beside < at { (other, &node) } else { (&node, other) };
            let moments = PixelMoments::pair(&left.moments, &right.moments, level);
            node = SumNode { level: level + 1, index: node.index >> 1, moments };
            self.nodes.remove(beside);
            at = at.min(beside);
        }
        self.nodes.insert(at, node);
        Ok(())
    }
}

impl TryFrom<Vec<SumNode>> for SampleSums {
    type Error = Overlap;

    fn try_from(nodes: Vec<SumNode>) -> Result<Self, Overlap> {
        Self::from_nodes(nodes)
    }
}

impl From<SampleSums> for Vec<SumNode> {
    fn from(sums: SampleSums) -> Self {
        sums.nodes
    }
}

/// The error of adding a sample twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overlap {
    /// Index of the first sample that both parts have; `u64::MAX` if an index is not below 2⁶³.
    pub index: u64,
}

impl fmt::Display for Overlap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.index {
            u64::MAX => write!(f, "cannot add samples whose index is not below 2^63"),
            index => write!(f, "cannot add sample {index} twice; the parts of a render must not overlap"),
        }
    }
}

impl std::error::Error for Overlap {}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_testkit::Rng;

    fn sample(s: u64) -> DVec3 {
        let mut rng = Rng::new(s);
        // One sample in 64 is far brighter than the others.
        let bright = if rng.f64() < 1.0 / 64.0 { 1e4 } else { 1.0 };
        DVec3::new(rng.f64() * bright, 1e6 + rng.f64(), 0.7)
    }

    fn range(samples: std::ops::Range<u64>) -> SampleSums {
        let mut sums = SampleSums::default();
        samples.for_each(|s| sums.add(s, sample(s)).unwrap());
        sums
    }

    /// A number below n.
    fn below(rng: &mut Rng, n: usize) -> usize {
        (rng.f64() * n as f64) as usize
    }

    #[test]
    fn any_partition_in_any_order_has_the_same_bits() {
        let mut rng = Rng::new(7);
        for trial in 0..300 {
            let (first, n) = (below(&mut rng, 70) as u64 * (trial % 2), 1 + below(&mut rng, 400) as u64);
            let whole = range(first..first + n);
            let mut cuts: Vec<u64> =
                (0..below(&mut rng, 9)).map(|_| first + below(&mut rng, n as usize) as u64).collect();
            cuts.extend([first, first + n]);
            cuts.sort_unstable();
            let mut parts: Vec<SampleSums> = cuts.windows(2).map(|cut| range(cut[0]..cut[1])).collect();
            let mut sums = SampleSums::default();
            while !parts.is_empty() {
                let part = parts.remove(below(&mut rng, parts.len()));
                sums.merge(&part).unwrap();
            }
            assert_eq!((sums.finish(), &sums), (whole.finish(), &whole), "{cuts:?}");
            let restored = SampleSums::from_nodes(sums.nodes().iter().rev().copied()).unwrap();
            assert_eq!(restored, whole);
        }
    }

    /// Samples in any order, also sets with gaps.
    #[test]
    fn the_order_of_samples_does_not_matter() {
        let mut rng = Rng::new(8);
        let set: Vec<u64> = (0..300).filter(|_| rng.f64() < 0.8).collect();
        let of = |order: &[u64]| {
            let mut sums = SampleSums::default();
            order.iter().for_each(|s| sums.add(*s, sample(*s)).unwrap());
            sums
        };
        let sorted = of(&set);
        for _ in 0..20 {
            let mut left = set.clone();
            let mut order = Vec::new();
            while !left.is_empty() {
                order.push(left.swap_remove(below(&mut rng, left.len())));
            }
            assert_eq!(of(&order), sorted);
        }
        assert_eq!(sorted.finish().0, set.len() as u64);
    }

    /// The mean and the variance in two passes.
    #[test]
    fn moments_agree_with_two_passes() {
        for (first, n) in [(0, 1), (0, 2), (5, 1), (0, 3), (1, 6), (0, 1000), (77, 4321), (0, 1 << 16)] {
            let samples = || (first..first + n).map(sample);
            let rough = samples().sum::<DVec3>() / n as f64;
            // The sum in order, not that of the tree, has the larger rounding error.
            let mean = rough + samples().map(|x| x - rough).sum::<DVec3>() / n as f64;
            let m2 = samples().map(|x| (x - mean) * (x - mean)).sum::<DVec3>();
            let (count, found) = range(first..first + n).finish();
            assert_eq!(count, n);
            assert!(((found.mean - mean) / mean).abs().max_element() < 1e-14, "{n}: {found:?} {mean}");
            // The second pass cancels digits of the second channel, whose mean is 1e6 times its deviation.
            assert!((found.m2 - m2).abs().cmple(m2 * 1e-8 + 1e-20).all(), "{n}: {found:?} {m2}");
            assert_eq!((found.mean.z, found.m2.z), (0.7, 0.0));
        }
    }

    /// Of a million samples of uniform numbers in steps of 2⁻²⁰, the mean is exact, because no step rounds, and the
    /// squared deviations agree with integers.
    #[test]
    fn a_million_samples() {
        let n = 1 << 20;
        let mut sums = SampleSums::default();
        let (mut sum, mut squares) = (0u128, 0u128);
        for s in 0..n {
            let k = (s * 0x9e37_79b1) % n;
            sum += u128::from(k);
            squares += u128::from(k) * u128::from(k);
            sums.add(s, DVec3::new(k as f64 / n as f64, 1e6 + k as f64 / n as f64, 0.1)).unwrap();
        }
        let (count, found) = sums.finish();
        let wanted = sum as f64 / n as f64 / n as f64;
        assert_eq!((count, found.mean.x, found.mean.z), (n, wanted, 0.1));
        assert_eq!(sums.nodes().len(), 1);
        let exact = (squares * u128::from(n) - sum * sum) as f64 / (n as f64).powi(3);
        assert!((found.m2.x / exact - 1.0).abs() < 1e-14, "{} {exact}", found.m2.x);
        assert!((found.mean.y - 1e6 - wanted).abs() < 1e-9 && (found.m2.y / exact - 1.0).abs() < 1e-9);
    }

    #[test]
    fn constants_have_no_variance() {
        for (first, n) in [(0, 1000), (3, 777), (64, 64)] {
            let mut sums = SampleSums::default();
            let value = DVec3::new(0.1, 1e30, 1e-30);
            (first..first + n).for_each(|s| sums.add(s, value).unwrap());
            assert_eq!(sums.finish(), (n, PixelMoments::of(value)));
        }
        assert_eq!(PixelMoments::of(DVec3::ONE).variance_of_mean(1), DVec3::INFINITY);
    }

    #[test]
    fn a_sample_is_not_added_twice() {
        let mut sums = range(3..20);
        let before = sums.clone();
        assert_eq!(sums.add(7, DVec3::ONE), Err(Overlap { index: 7 }));
        assert_eq!(sums.merge(&range(0..4)), Err(Overlap { index: 3 }));
        assert_eq!(sums.merge(&range(19..30)), Err(Overlap { index: 19 }));
        assert_eq!(sums, before);
        let far = SumNode { level: 40, index: 1 << 30, moments: PixelMoments::default() };
        assert!(SampleSums::from_nodes([far]).is_err());
        let last = SumNode { level: 0, index: (1 << 63) - 1, ..far };
        let first = SumNode { index: 0, ..last };
        assert_eq!(SampleSums::from_nodes([last, first]).unwrap().finish().0, 2);
    }
}
