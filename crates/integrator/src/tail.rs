//! The samples that deviate most: do a few of them make up the variance?

/// How many are kept of each tile, and of the picture: enough to tell how fast their sizes fall, to an eighth.
pub const KEPT: usize = 64;

/// The largest squared deviations of samples from the means of their pixels, sums over three channels. The same at any
/// number of threads, for a pixel's samples come in order and a tile's pixels too.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tail {
    /// In no order; the largest are among them, and at most as many others.
    squares: Vec<f64>,
    /// What does not exceed it is not among the largest.
    least: f64,
}

impl Tail {
    /// Takes in a squared deviation. Few samples are among the largest: nearly always one comparison.
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

    /// Those of `other` too.
    pub fn merge(&mut self, other: &Self) {
        other.squares.iter().for_each(|square| self.add(*square));
    }

    /// The largest first.
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
