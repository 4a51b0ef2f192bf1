//! The largest differences of samples, to check whether a few samples dominate the variance.

/// Number of differences kept per tile, and for the image: enough to estimate how fast their sizes decrease, to one
/// eighth.
pub const KEPT: usize = 64;

/// The largest squared differences of the two samples of a pair, samples 2i and 2i + 1 of a pixel, as sums over three
/// channels. A sample that is far brighter than the others is as far from its neighbour as from the mean of its pixel,
/// but the neighbour is the same in whatever parts the samples are added. [`dapple_camera::Film::unpaired`] has the
/// deviations of the samples whose neighbour is missing. Independent of the number of threads, tiles and passes.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tail {
    /// Unordered; contains the largest values, and at most as many others.
    squares: Vec<f64>,
    /// Values up to this bound are not among the largest.
    least: f64,
}

impl Tail {
    /// Adds a squared difference. As few samples are among the largest, this is usually a single comparison.
    #[inline]
    pub fn add(&mut self, square: f64) {
        if square > self.least {
            self.keep(square);
        }
    }

    #[cold]
    fn keep(&mut self, square: f64) {
        self.squares.push(square);
        if self.squares.len() == 2 * KEPT {
            let (_, least, _) = self.squares.select_nth_unstable_by(KEPT - 1, |a, b| b.total_cmp(a));
            self.least = *least;
            self.squares.truncate(KEPT);
        }
    }

    /// Adds the differences of `other`.
    pub fn merge(&mut self, other: &Self) {
        other.squares.iter().for_each(|square| self.add(*square));
    }

    /// The largest differences, in descending order.
    pub fn sorted(&self) -> Vec<f64> {
        let mut all = self.squares.clone();
        all.sort_by(|a, b| b.total_cmp(a));
        all.truncate(KEPT);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_are_kept_whatever_the_order() {
        let numbers: Vec<f64> = (0..1000u64).map(|i| (i * 7919 % 1009) as f64).collect();
        let mut sorted = numbers.clone();
        sorted.sort_by(|a, b| b.total_cmp(a));
        let tail = |numbers: &[f64]| {
            let mut tail = Tail::default();
            numbers.iter().for_each(|n| tail.add(*n));
            tail
        };
        let whole = tail(&numbers);
        assert_eq!(whole.sorted(), sorted[..KEPT]);
        let (mut a, b) = (tail(&numbers[..300]), tail(&numbers[300..]));
        a.merge(&b);
        assert_eq!(a.sorted(), whole.sorted());
        assert_eq!(tail(&[0.0, 3.0, 1.0, 0.0]).sorted(), [3.0, 1.0]);
    }
}
