//! Cumulative distributions of one or more rows of as many bins, and their inversion over lanes.

use dapple_math::lanes::{Mask, Real, Word};

/// The largest number below 1.
pub const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;

/// Largest number of parts of the guide of a row, so that the part of a u in f32 is found exactly.
const MOST_PARTS: usize = 1 << 23;

/// Rows of cumulative distributions over `bins` bins.
///
/// The guide of a row gives the first bin for each of about `bins` equal parts of u [Chen & Asau 1974]; the few bins of a
/// part are searched by halves.
#[derive(Clone, Debug)]
pub struct Table {
    bins: usize,
    parts: usize,
    /// Per row bins + 1 pairs of numbers: both parts of the probability of a lower bin (see [`split`]). The last of a row
    /// is exactly 1. Rows of weight 0 are zeros.
    edges: Vec<f32>,
    /// Per row parts + 1 bins: that of u = g/parts, and at the end the last bin of positive probability.
    guide: Vec<u32>,
}

/// A bin found by [`Table::sample`]: its index, its probability, and u rescaled to [0,1) within it.
pub struct Found<R: Real> {
    pub index: R::Word,
    pub pmf: R,
    pub u: R,
}

impl Table {
    /// Creates a table without rows. It is None if its numbers could not be addressed by 31 bits.
    pub fn new(bins: usize, rows: usize) -> Option<Self> {
        let numbers = bins.checked_add(1)?.checked_mul(2)?.checked_mul(rows)?;
        let parts = bins.checked_next_power_of_two()?.min(MOST_PARTS);
        if bins == 0 || numbers >= 1 << 31 {
            return None;
        }
        let guide = Vec::with_capacity(rows * (parts + 1));
        Some(Self { bins, parts, edges: Vec::with_capacity(numbers), guide })
    }

    /// Adds a row with probabilities proportional to `weights`, one per bin, which are finite and not negative. Returns
    /// the sum of the weights, or None if it is 0 or not finite, in which case the row has no probabilities.
    pub fn push(&mut self, weights: &[f64]) -> Option<f64> {
        let sum: f64 = weights.iter().sum();
        let last = weights.iter().rposition(|w| *w > 0.0).filter(|_| sum > 0.0 && sum.is_finite());
        let Some(last) = last else {
            self.edges.resize(self.edges.len() + 2 * (self.bins + 1), 0.0);
            self.guide.resize(self.guide.len() + self.parts + 1, 0);
            return None;
        };
        let start = self.edges.len();
        self.edges.extend(split(0.0));
        let mut running = 0.0;
        for (i, w) in weights.iter().enumerate() {
            running += w;
            // Rounding must not leave a gap after the last bin with a positive weight.
            self.edges.extend(split(if i >= last { 1.0 } else { (running / sum).min(1.0) }));
        }
        let mut bin = 0;
        for g in 0..self.parts {
            while self.edges[start + 2 * bin + 2] <= g as f32 / self.parts as f32 {
                bin += 1;
            }
            self.guide.push(bin as u32);
        }
        self.guide.push(last as u32);
        Some(sum)
    }

    /// Inverts the distribution of a row at `u`, which is clamped to [0, 1 − 2⁻²⁴]; NaN counts as 0. A bin of
    /// probability 0 is never found in a row of positive weight.
    #[inline(always)]
    pub fn sample<R: Real>(&self, row: R::Word, u: R) -> Found<R> {
        let u = u.max(R::splat(0.0)).min(R::splat(LARGEST));
        let index = self.search(row, u);
        let [edge, rest, pmf] = self.bin(self.start::<R>(row), index);
        let within = ((u - edge) - rest) / pmf;
        Found { index, pmf, u: within.max(R::splat(0.0)).min(R::splat(LARGEST)) }
    }

    /// Returns the first bin of a row whose upper edge is above `u`, which is in [0, 1 − 2⁻²⁴].
    #[inline(always)]
    pub fn search<R: Real>(&self, row: R::Word, u: R) -> R::Word {
        let one = R::Word::splat(1);
        let part = (u * R::splat(self.parts as f32)).to_int();
        let part = part.wrapping_add(row.wrapping_mul(R::Word::splat(self.parts as u32 + 1)));
        let start = self.start::<R>(row);
        let mut low = R::Word::gather(&self.guide, part);
        let mut high = R::Word::gather(&self.guide, part.wrapping_add(one));
        loop {
            let open = low.lt(high);
            if !open.any() {
                break;
            }
            let middle = low.wrapping_add(high) >> 1;
            let next = middle.wrapping_add(one);
            let is_above = R::gather(&self.edges, start.wrapping_add(next << 1)).le(u);
            low = R::Word::select(open & is_above, next, low);
            high = R::Word::select(open & !is_above, middle, high);
        }
        low
    }

    /// Returns the probability of a bin of a row.
    #[inline(always)]
    pub fn pmf<R: Real>(&self, row: R::Word, index: R::Word) -> R {
        self.bin(self.start::<R>(row), index)[2]
    }

    /// Returns the place of the first number of a row.
    #[inline(always)]
    fn start<R: Real>(&self, row: R::Word) -> R::Word {
        row.wrapping_mul(R::Word::splat(2 * self.bins as u32 + 2))
    }

    /// Returns both parts of the lower edge of a bin, and its probability.
    #[inline(always)]
    fn bin<R: Real>(&self, start: R::Word, index: R::Word) -> [R; 3] {
        let at = start.wrapping_add(index << 1);
        let (one, two) = (R::Word::splat(1), R::Word::splat(2));
        let next = at.wrapping_add(two);
        let (low, low_rest) = (R::gather(&self.edges, at), R::gather(&self.edges, at.wrapping_add(one)));
        let (high, high_rest) =
            (R::gather(&self.edges, next), R::gather(&self.edges, next.wrapping_add(one)));
        [low, low_rest, (high - low) + (high_rest - low_rest)]
    }

    /// Inverts the distribution of the first row at `bits`/2³², and returns the bin and its place within it.
    pub fn sample_bits(&self, bits: u32) -> (usize, f32) {
        let u = f64::from(bits) / 4_294_967_296.0;
        let part = (u * self.parts as f64) as usize;
        let (mut bin, mut end) = (self.guide[part] as usize, self.guide[part + 1] as usize);
        while bin < end {
            let middle = (bin + end) / 2;
            if self.edge(middle + 1) <= u {
                bin = middle + 1;
            } else {
                end = middle;
            }
        }
        let within = (u - self.edge(bin)) / (self.edge(bin + 1) - self.edge(bin));
        (bin, (within as f32).clamp(0.0, LARGEST))
    }

    /// Returns the probability of the bins below `index` ≤ bins of the first row.
    pub fn edge(&self, index: usize) -> f64 {
        f64::from(self.edges[2 * index]) + f64::from(self.edges[2 * index + 1])
    }

    /// Returns the number of bins of a row.
    pub fn bins(&self) -> usize {
        self.bins
    }
}

/// Splits 0 ≤ x ≤ 1 into the smallest f32 that is not below it, and the rest, which is not positive. A u in f32 is below
/// x exactly if it is below the first part. The sum is x to within 2⁻⁴⁸ of it.
fn split(x: f64) -> [f32; 2] {
    let near = x as f32;
    let first = if f64::from(near) < x { near.next_up() } else { near };
    // Even after rounding, the sum stays above the f32 before the first part, so that no bin that is found is empty.
    let least = (f64::from(first.next_down()) - f64::from(first)) as f32;
    let rest = (x - f64::from(first)) as f32;
    [first, rest.max(least.next_up()).min(0.0)]
}
