//! Keys of random numbers. A random number is a pure function of (seed, pixel, branch, depth, decision); there is no
//! generator with a state.

use crate::hash::{mix64, unit};

/// Identifies one stream of sample points. Equal keys give equal points on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key(u64);

impl Key {
    /// Returns the key of one pixel of a render with the given seed.
    pub fn pixel(seed: u64, x: u32, y: u32) -> Self {
        Self(mix64(mix64(seed) ^ ((u64::from(x) << 32) | u64::from(y))))
    }

    /// Returns the key of the `n`-th branch where a path is split.
    #[inline]
    pub fn branch(self, n: u32) -> Self {
        Self(mix64(self.0 ^ (0xB5AD_4ECE_DA1C_E2A9u64.wrapping_add(u64::from(n)).rotate_left(17))))
    }

    /// Returns the key of one random decision at `depth`. `decision` is its number in the caller's table of decisions
    /// and is below 256.
    #[inline]
    pub fn at(self, depth: u32, decision: impl Into<u32>) -> Self {
        Self(mix64(self.0.wrapping_add((u64::from(depth) << 8) | u64::from(decision.into()))))
    }

    /// Returns the key of a sequence of words, for decisions that depend on the surface that was hit or on the query.
    #[inline]
    pub fn hash(words: impl IntoIterator<Item = u64>) -> Self {
        Self(words.into_iter().fold(0, |hash, word| mix64(hash ^ word)))
    }

    /// Returns one random number in [0, 1), a multiple of 2⁻²⁴.
    #[inline]
    pub fn unit(self) -> f32 {
        unit((self.0 >> 32) as u32)
    }

    /// Returns the key as 64 hashed bits.
    #[inline]
    pub fn bits(self) -> u64 {
        self.0
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
        assert_eq!(Key::pixel(0, 0, 0).bits(), 12_035_550_249_420_947_055);
        assert_eq!(Key::pixel(1, 2, 3).at(0, 0u32).bits(), 18_106_437_220_738_762_080);
        assert_eq!(
            Key::pixel(u64::MAX, 7, 9).branch(3).at(u32::MAX, 9u32).bits(),
            11_847_629_566_514_735_717
        );
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
}
