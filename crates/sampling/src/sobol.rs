//! An Owen-scrambled (0,2)-sequence with 32-bit indices, in which no point repeats before 2^32.
//!
//! Dimension 0 is the van der Corput sequence (bit reversal), and dimension 1 is the second Sobol dimension. Both get a
//! nested uniform scrambling by a hash that only propagates upward on the reversed bits [Burley 2020, JCGT 9-4], with
//! the constants of [Vegdahl 2021], which mix better. The index is shuffled in the same way, so that different keys
//! start with different parts of the sequence, and every aligned block of 2^m indices is still a net.
//!
//! Two keys that are used for two integrals over the same sample index (pads) need an additional permutation. Under
//! these shuffles, indices 2k and 2k + 1 lie in opposite halves for every key. The signs of the centred product of two
//! pads are then equal in pairs, and its error has 1.5 times the variance of independent points (docs/science.md,
//! "Points"). [`pad`] therefore permutes the indices within blocks of 16 first.

use crate::hash::{mix64, unit};
use crate::key::Key;
use glam::Vec2;

/// Returns the nested uniform scramble of bit-reversed `x`: bit i of the result is bit i of `x`, flipped depending on
/// the bits below it [Laine & Karras 2011; constants Vegdahl 2021].
#[inline]
fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x
}

/// Returns the second Sobol dimension of an index, bit-reversed. Its generator matrix is Pascal's triangle mod 2,
/// applied as a product of the factors (I + shift by 2^k) for k = 4..0.
fn pascal_reversed(mut x: u32) -> u32 {
    x ^= x >> 16;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^ ((x & 0xaaaa_aaaa) >> 1)
}

/// Shuffles the index by an Owen scramble selected by `seed`, which maps every aligned block of 2^m indices to such a
/// block. Without it, the points of two keys would be in corresponding halves at every index.
fn shuffle(s: u32, seed: u32) -> u32 {
    laine_karras(s.reverse_bits(), seed).reverse_bits()
}

/// Returns the index of sample `s` of `n` where several integrals share s. It is permuted by the key within aligned
/// blocks of 16 (or of the largest power of two up to n, if that is smaller), so that the points of two pads are paired
/// at random while blocks stay nets.
///
/// Any two indices of a block are mapped to any two positions with equal probability by x → a·x + c over the field of
/// 16 elements (or 8, 4, 2; modulus x^b + x + 1). This alone makes the variance of a paired sum that of a random
/// pairing. It is followed by x → m·x + k mod 16, so that two orders are not linear maps of each other. n only has an
/// effect below 16, so that a render can be continued with a larger n.
#[inline]
pub fn pad(s: u32, n: u32, key: Key) -> u32 {
    let bits = n.max(1).ilog2().min(4);
    if bits == 0 {
        return s;
    }
    let mask = (1 << bits) - 1;
    let k = mix64(key.bits() ^ (0xB10C << 48) ^ u64::from(s >> bits));
    let a = 1 + (((k & 0xffff_ffff) * u64::from(mask)) >> 32) as u32;
    let k = (k >> 32) as u32;
    let x = times(a, s & mask, bits) ^ k;
    let x = x.wrapping_mul((k >> 8) | 1).wrapping_add(k >> 16);
    (s & !mask) | (x & mask)
}

/// Returns the product in the field of 2^bits elements, bits ≤ 4.
#[inline]
fn times(a: u32, x: u32, bits: u32) -> u32 {
    let p = (0..4).fold(0, |p, i| p ^ ((a << i) & (x >> i & 1).wrapping_neg()));
    // x^b = x + 1. The high part has at most 3 bits, so that one reduction is enough.
    let high = p >> bits;
    (p ^ high ^ (high << 1)) & ((1 << bits) - 1)
}

/// Returns the one-dimensional point `s` in units of 2^-32. No value repeats before s = 2^32.
#[inline]
pub fn bits_1d(s: u32, key: Key) -> u32 {
    let k = key.bits();
    laine_karras(shuffle(s, k as u32), (k >> 32) as u32).reverse_bits()
}

/// Returns the two-dimensional point `s` in units of 2^-32. In each coordinate, no value repeats before s = 2^32.
#[inline]
pub fn bits_2d(s: u32, key: Key) -> [u32; 2] {
    let k = key.bits();
    let seeds = mix64(k);
    let index = shuffle(s, k as u32);
    // Dimension 0 is the reversed index, and an Owen scramble lies between two reversals, so that the inner ones
    // cancel.
    let x = laine_karras(index, seeds as u32);
    let y = laine_karras(pascal_reversed(index), (seeds >> 32) as u32);
    let both = (u64::from(y) | u64::from(x) << 32).reverse_bits();
    [both as u32, (both >> 32) as u32]
}

/// Returns point `s` in [0,1), a multiple of 2^-24.
#[inline]
pub fn point_1d(s: u32, key: Key) -> f32 {
    unit(bits_1d(s, key))
}

/// Returns point `s` in [0,1)², with coordinates that are multiples of 2^-24.
#[inline]
pub fn point_2d(s: u32, key: Key) -> Vec2 {
    let [x, y] = bits_2d(s, key);
    Vec2::new(unit(x), unit(y))
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
        // 7·9 in the field of 16: (x²+x+1)(x³+1) = x^5+x^4+x³+x²+x+1 = (x²+x)+(x+1)+x³+x²+x+1 = x³+x.
        assert_eq!(times(7, 9, 4), 10);
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
            assert_eq!(pascal_reversed(i).reverse_bits(), y);
        }
    }

    /// An output bit depends only on the same and lower bits of the input, and each seed gives a bijection.
    #[test]
    fn the_hash_only_carries_upward() {
        let key = Key::pixel(1, 2, 3).bits();
        for shift in 0..32u32 {
            let seed = (key >> (shift % 32)) as u32;
            let x = (key as u32).rotate_left(shift);
            let change = laine_karras(x, seed) ^ laine_karras(x ^ (1 << shift), seed);
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
