//! An Owen-scrambled (0,2)-sequence with 32-bit indices, in which no point repeats before 2^32.
//!
//! Dimension 0 is the van der Corput sequence (bit reversal), and dimension 1 is the second Sobol dimension. Both get a
//! nested uniform scrambling that only propagates upward on the reversed bits [Burley 2020, JCGT 9-4], x → m·x + c with
//! m and c from the key, whose pairs of points have the law of pairs under a nested uniform scramble. The index is
//! shuffled in the same way, so that different keys start with different parts of the sequence, and every aligned block
//! of 2^m indices is still a net.
//!
//! Two keys that are used for two integrals over the same sample index (pads) need an additional permutation. Under
//! these shuffles, indices 2k and 2k + 1 lie in opposite halves for every key. The signs of the centred product of two
//! pads are then equal in pairs, and its error has 1.5 times the variance of independent points (docs/science.md,
//! "Points"). [`pad`] therefore permutes the indices within blocks of 16 first.

use crate::Key;
use crate::lanes::sobol;
use glam::Vec2;

/// Returns the index of sample `s` of `n` where several integrals share s. It is permuted by the key within aligned
/// blocks of 16 (or of the largest power of two up to n, if that is smaller), so that the points of two pads are paired
/// at random while blocks stay nets. n only has an effect below 16, so that a render can be continued with a larger n.
#[inline]
pub fn pad(s: u32, n: u32, key: Key) -> u32 {
    sobol::pad(s.reverse_bits(), n, key).reverse_bits()
}

/// Returns the one-dimensional point `s` in units of 2^-32. No value repeats before s = 2^32.
#[inline]
pub fn bits_1d(s: u32, key: Key) -> u32 {
    sobol::bits_1d(s.reverse_bits(), key)
}

/// Returns the two-dimensional point `s` in units of 2^-32. In each coordinate, no value repeats before s = 2^32.
#[inline]
pub fn bits_2d(s: u32, key: Key) -> [u32; 2] {
    sobol::bits_2d(s.reverse_bits(), key)
}

/// Returns point `s` in [0,1), a multiple of 2^-24.
#[inline]
pub fn point_1d(s: u32, key: Key) -> f32 {
    sobol::point_1d(s.reverse_bits(), key)
}

/// Returns point `s` in [0,1)², with coordinates that are multiples of 2^-24.
#[inline]
pub fn point_2d(s: u32, key: Key) -> Vec2 {
    sobol::point_2d(s.reverse_bits(), key).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every elementary interval of area 2^-m contains exactly one of the first 2^m points.
    #[test]
    fn is_a_0_m_2_net() {
        for seed in 0..20 {
            let key = Key::pixel(seed, 5, 9);
            for m in 0..=8u32 {
                for a in 0..=m {
                    let mut seen = vec![false; 1 << m];
                    for s in 0..1 << m {
                        let p = point_2d(s, key);
                        let i = (p.x * (1 << a) as f32) as usize;
                        let j = (p.y * (1 << (m - a)) as f32) as usize;
                        let cell = i << (m - a) | j;
                        assert!(!seen[cell], "m {m} a {a} seed {seed}");
                        seen[cell] = true;
                    }
                }
            }
        }
    }

    #[test]
    fn first_coordinate_is_stratified_in_1d() {
        for seed in 0..20 {
            let mut seen = vec![false; 1024];
            (0..1024).for_each(|s| seen[(point_1d(s, Key::pixel(seed, 0, 0)) * 1024.0) as usize] = true);
            assert!(seen.iter().all(|&s| s));
        }
    }

    /// Each block is mapped to itself, and any pair of positions is equally likely for any pair of indices.
    #[test]
    fn pads_pair_at_random() {
        for bits in 1..=4u32 {
            let size = 1u32 << bits;
            for n in [size, 2 * size - 1] {
                let key = |seed| Key::pixel(seed, 8, 8);
                let mut seen = vec![false; 4 * size as usize];
                (0..4 * size).for_each(|s| seen[pad(s, n, key(1)) as usize] = true);
                assert!(seen.iter().all(|&s| s));
                let (i, j) = (0, size - 1);
                let mut pairs = vec![0.0; (size * size) as usize];
                let tries = 400 * size * size;
                for seed in 0..u64::from(tries) {
                    pairs[(pad(i, n, key(seed)) * size + pad(j, n, key(seed))) as usize] += 1.0;
                }
                let cells = f64::from(size * (size - 1));
                let expected = f64::from(tries) / cells;
                let chi2 = pairs.iter().map(|p: &f64| (p - expected).powi(2) / expected).sum::<f64>()
                    - expected * f64::from(size);
                assert!(chi2 < cells + 4.5 * (2.0 * cells).sqrt(), "{size}: {chi2} of {cells}");
            }
        }
    }

    /// Both dimensions are compared with their definition by the direction numbers of Sobol's first two dimensions.
    #[test]
    fn dimensions_are_sobols() {
        for i in (0..1000).chain([1 << 31, u32::MAX, 0x1234_5678]) {
            let (mut x, mut y) = (0u32, 0u32);
            let (mut v0, mut v1) = (1u32 << 31, 1u32 << 31);
            for bit in 0..32 {
                if i >> bit & 1 == 1 {
                    x ^= v0;
                    y ^= v1;
                }
                v0 >>= 1;
                v1 ^= v1 >> 1;
            }
            assert_eq!(i.reverse_bits(), x);
            assert_eq!(sobol::pascal_reversed(i).reverse_bits(), y);
        }
    }

    /// An output bit depends only on the same and lower bits of the input, and each seed gives a bijection.
    #[test]
    fn the_scramble_only_carries_upward() {
        let key = Key::pixel(1, 2, 3).bits();
        for shift in 0..32u32 {
            let scramble = sobol::Scramble::new((key >> (shift % 32)) as u32, (key >> 32) as u32);
            let x = (key as u32).rotate_left(shift);
            let change = scramble.of(x) ^ scramble.of(x ^ (1 << shift));
            assert_eq!(change.trailing_zeros(), shift);
        }
    }

    /// docs/science.md, "Points": 2^17 points all differ in each coordinate.
    #[test]
    fn does_not_repeat_after_65536() {
        let key = Key::pixel(1, 2, 3);
        for bits in [&|s| bits_1d(s, key), &|s| bits_2d(s, key)[0], &|s| bits_2d(s, key)[1]]
            as [&dyn Fn(u32) -> u32; 3]
        {
            let mut all: Vec<u32> = (0..1 << 17).map(bits).collect();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), 1 << 17);
        }
    }
}
