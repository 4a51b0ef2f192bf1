//! An Owen-scrambled (0,2)-sequence with 32-bit indices: no point repeats before 2^32.
//!
//! Dimension 0 is the van der Corput sequence (bit reversal), dimension 1 the second Sobol dimension. Each is nested-
//! uniformly scrambled by a hash that only propagates upward on the reversed bits [Burley 2020, JCGT 9-4], with the
//! better-mixing constants of [Vegdahl 2021]. The index is shuffled the same way, so that pads of different keys are
//! independent of one another.

use crate::hash::{mix64, unit};
use crate::key::Key;
use glam::Vec2;

/// Nested uniform scramble of bit-reversed `x`: bit i of the result depends only on bits below it [Vegdahl 2021].
fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x
}

/// Owen scramble of the fraction `x` / 2^32.
fn owen(x: u32, seed: u32) -> u32 {
    laine_karras(x.reverse_bits(), seed).reverse_bits()
}

/// Second Sobol dimension as a map of the bit-reversed index (its generator matrix is Pascal's triangle mod 2).
fn pascal(mut x: u32) -> u32 {
    x ^= x << 16;
    x ^= (x & 0x00ff_00ff) << 8;
    x ^= (x & 0x0f0f_0f0f) << 4;
    x ^= (x & 0x3333_3333) << 2;
    x ^ ((x & 0x5555_5555) << 1)
}

/// First coordinate of point `s`, 32 bits.
pub fn bits_1d(s: u32, key: Key) -> u32 {
    let k = key.bits();
    // The index shuffle works on the reversed index, which is dimension 0 already; its own scramble then suffices.
    let x = laine_karras(s, k as u32).reverse_bits();
    owen(x, (k >> 32) as u32)
}

/// Point `s` in [0,1).
pub fn point_1d(s: u32, key: Key) -> f32 {
    unit(bits_1d(s, key))
}

/// Point `s` in [0,1)².
pub fn point_2d(s: u32, key: Key) -> Vec2 {
    let k = key.bits();
    let index = laine_karras(s.reverse_bits(), k as u32).reverse_bits();
    let more = mix64(k);
    let x = owen(index.reverse_bits(), more as u32);
    let y = owen(pascal(index.reverse_bits()), (more >> 32) as u32);
    Vec2::new(unit(x), unit(y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every elementary interval of area 2^-m holds exactly one of the first 2^m points.
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

    #[test]
    fn does_not_repeat_after_65536() {
        let key = Key::pixel(1, 2, 3);
        let first: std::collections::HashSet<u32> = (0..65536).map(|s| bits_1d(s, key)).collect();
        let again = (65536..131072).filter(|&s| first.contains(&bits_1d(s, key))).count();
        assert!(again < 10, "{again} of 65536 repeat");
    }
}
