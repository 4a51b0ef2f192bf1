//! Randomness keyed by name: a pure function of (seed, pixel, branch, depth, dimension), never drawn in sequence.

use crate::Dimension;
use crate::hash::mix64;

/// Names one stream of points. Equal keys give equal points on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key(u64);

impl Key {
    /// The key of one pixel of one render.
    pub fn pixel(seed: u64, x: u32, y: u32) -> Self {
        Self(mix64(mix64(seed) ^ ((u64::from(x) << 32) | u64::from(y))))
    }

    /// The `n`-th child of a splitting.
    #[inline]
    pub fn branch(self, n: u32) -> Self {
        Self(mix64(self.0 ^ (0xB5AD_4ECE_DA1C_E2A9u64.wrapping_add(u64::from(n)).rotate_left(17))))
    }

    /// The key of one decision.
    #[inline]
    pub fn at(self, depth: u32, dimension: Dimension) -> Self {
        Self(mix64(self.0.wrapping_add((u64::from(depth) << 8) | dimension as u64)))
    }

    /// 64 well-mixed bits.
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
                for d in [Dimension::Pixel, Dimension::Lobe, Dimension::ShadowAlpha] {
                    assert!(seen.insert(pixel.at(depth, d).bits()));
                    assert!(seen.insert(pixel.branch(depth).at(0, d).bits()));
                }
            }
        }
    }

    #[test]
    fn bits_are_a_promise() {
        assert_eq!(
            Key::pixel(0, 0, 0).at(0, Dimension::Pixel).bits(),
            Key::pixel(0, 0, 0).at(0, Dimension::Pixel).bits()
        );
        assert_ne!(Key::pixel(0, 1, 0), Key::pixel(0, 0, 1));
    }
}
