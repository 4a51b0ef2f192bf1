//! Keys of random numbers. A random number is a pure function of (seed, pixel, branch, depth, decision); there is no
//! generator with a state.

use crate::lanes::Keyx;

/// Identifies one stream of sample points. Equal keys give equal points on every machine. It has the methods of
/// [`Keyx`], which holds one key per lane.
pub type Key = Keyx<u32>;

impl Key {
    /// Returns the key of a sequence of words, for decisions that depend on the surface that was hit or on the query.
    #[inline]
    pub fn hash(words: impl IntoIterator<Item = u64>) -> Self {
        words.into_iter().fold(Self::start(), |key, word| key.with(word as u32, (word >> 32) as u32))
    }

    /// Returns the key as 64 hashed bits.
    #[inline]
    pub fn bits(self) -> u64 {
        let [low, high] = self.words();
        u64::from(high) << 32 | u64::from(low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn names_do_not_collide() {
        let mut seen = HashSet::new();
        for x in 0..16 {
            let pixel = Key::pixel(7, x, 3);
            for depth in 0..100 {
                for d in [0u32, 3, 9] {
                    assert!(seen.insert(pixel.at(depth, d).bits()));
                    assert!(seen.insert(pixel.branch(depth).at(0, d).bits()));
                }
            }
        }
    }

    /// The bits must never change, because the replay of pixels and the merging of images depend on them.
    #[test]
    fn bits_are_a_promise() {
        assert_eq!(Key::pixel(0, 0, 0).bits(), 13_392_318_495_749_641_668);
        assert_eq!(Key::pixel(1, 2, 3).at(0, 0u32).bits(), 16_243_789_508_490_919_158);
        assert_eq!(Key::pixel(u64::MAX, 7, 9).branch(3).at(u32::MAX, 9u32).bits(), 6_331_490_058_715_551_003);
    }

    /// Flipping a bit of any input changes each bit of the key with probability ½.
    #[test]
    fn names_avalanche() {
        let key = |seed, x, y, n, depth| Key::pixel(seed, x, y).branch(n).at(depth, 3u32).bits();
        let mut flips = [0u32; 64];
        let trials = 200;
        for t in 0..trials {
            let base = key(t, 3, 5, 1, 2);
            for bit in 0..32 {
                let b = 1 << bit;
                for other in [
                    key(t ^ u64::from(b), 3, 5, 1, 2),
                    key(t, 3 ^ b, 5, 1, 2),
                    key(t, 3, 5 ^ b, 1, 2),
                    key(t, 3, 5, 1 ^ b, 2),
                    key(t, 3, 5, 1, 2 ^ b),
                ] {
                    (0..64).for_each(|i| flips[i] += ((base ^ other) >> i & 1) as u32);
                }
            }
        }
        // Binomial(32 000, ½): 16 000 ± 5·89.
        assert!(flips.iter().all(|f| (15_550..16_450).contains(f)), "{flips:?}");
    }

    /// Counts how often each of 64 output bits changes with each of the given input bits, and returns the largest
    /// deviation from half of the trials in standard deviations.
    fn worst(inputs: u32, trials: u64, key: impl Fn(u64, Option<u32>) -> u64) -> f64 {
        let mut flips = vec![[0u32; 64]; inputs as usize];
        for t in 0..trials {
            let base = key(t, None);
            for (input, flips) in flips.iter_mut().enumerate() {
                let change = base ^ key(t, Some(input as u32));
                flips.iter_mut().enumerate().for_each(|(i, f)| *f += (change >> i & 1) as u32);
            }
        }
        let half = trials as f64 / 2.0;
        let z = |f: &u32| (f64::from(*f) - half).abs() / (half / 2.0).sqrt();
        flips.iter().flatten().map(z).fold(0.0, f64::max)
    }

    /// Each bit of the key changes with probability ½ when one bit of one name changes, for every pair of such bits. Of
    /// 20 000 pairs of independent bits, one exceeds 6 standard deviations in 25 000 tests.
    #[test]
    fn every_bit_of_a_name_changes_every_bit_of_the_key() {
        let flip = |word: u32, bit: Option<u32>, first: u32| {
            word ^ bit.and_then(|b| b.checked_sub(first)).filter(|b| *b < 32).map_or(0, |b| 1 << b)
        };
        // Names under a random key: depth and decision, or the number of a branch.
        let names = worst(63, 20_000, |t, bit| Key::hash([t]).at(flip(2, bit, 0), flip(3, bit, 32)).bits());
        let branches = worst(32, 20_000, |t, bit| Key::hash([t]).branch(flip(1, bit, 0)).bits());
        let pixels = worst(128, 20_000, |t, bit| {
            let seed = u64::from(flip(t as u32, bit, 0)) | u64::from(flip(0, bit, 32)) << 32;
            Key::pixel(seed, flip(31, bit, 64), flip(57, bit, 96)).bits()
        });
        // Neighbouring pixels of one image, and small depths of one pixel.
        let image = worst(64, 20_000, |t, bit| {
            Key::pixel(0, flip(t as u32 % 200, bit, 0), flip(t as u32 / 200, bit, 32)).bits()
        });
        let words = worst(64, 20_000, |t, bit| {
            let word = Key::hash([t ^ 0xabc]).bits();
            Key::hash([word ^ bit.map_or(0, |b| 1 << b)]).bits()
        });
        for z in [names, branches, pixels, image, words] {
            assert!(z < 6.0, "{names:.2} {branches:.2} {pixels:.2} {image:.2} {words:.2}");
        }
    }

    /// A million decisions of one key are different, for small, large and sparse depths.
    #[test]
    fn decisions_of_one_key_differ() {
        let key = Key::pixel(9, 8, 7);
        let depths = (0..2000).chain((0..32).map(|b| 1 << b)).chain((0..2000).map(|d| u32::MAX - d));
        let names = depths.flat_map(|depth| (0..256u32).map(move |d| (depth, d)));
        let distinct: HashSet<(u32, u32)> = names.collect();
        let keys: HashSet<u64> = distinct.iter().map(|&(depth, d)| key.at(depth, d).bits()).collect();
        assert_eq!(keys.len(), distinct.len());
    }
}
