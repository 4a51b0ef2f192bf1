//! Integer hashes over words, which are the same in all versions and on all machines.

use super::integer::{OfLane, by_lane};
use dapple_math::lanes::{Mask, Word};

/// A bijection of 64 bits in two words with full avalanche: four rounds, each of which multiplies one word after a part
/// of the other has been added to it modulo 2, and two shifts from the high bits to the low ones.
///
/// Each of the 4096 pairs of an input bit and an output bit changes together with a probability of ½ ± 0.005 for random
/// inputs, and of ½ ± 0.02 for small integers (400 000 inputs each). The constants are the best of a random search among
/// such rounds. Fewer than four multiplications do not pass, nor does the `pcg3d` of Jarzynski and Olano, which leaves
/// the highest bits of its inputs and the lowest of its outputs almost unmixed.
#[inline(always)]
pub fn mix<W: Word>([a, b]: [W; 2]) -> [W; 2] {
    let a = (a ^ (b >> 17)).wrapping_mul(W::splat(0x5bf0_9283));
    let b = (b ^ (a >> 18)).wrapping_mul(W::splat(0x10a8_b195));
    let a = (a ^ (b >> 14)).wrapping_mul(W::splat(0x4d1e_4b25));
    let b = (b ^ (a >> 15)).wrapping_mul(W::splat(0xf2f9_872f));
    let a = a ^ (b >> 17);
    [a, b ^ (a >> 14)]
}

/// Permutes i < n by the bijection on 0..n that `key` selects, with cycle walking over the next power of two [Kensler
/// 2013, in spirit]. Each step leaves the walk with a probability of at least ½.
#[inline(always)]
pub fn permute<W: Word>(i: W, n: u32, key: [W; 2]) -> W {
    if n <= 1 {
        return W::splat(0);
    }
    let domain = Domain::of(n);
    let mut x = domain.scramble(i, key);
    for _ in 0..STEPS {
        let outside = !x.lt(W::splat(n));
        if !outside.any() {
            return x;
        }
        x = W::select(outside, domain.scramble(x, key), x);
    }
    let outside = !x.lt(W::splat(n));
    by_lane(outside, x, key, Walk { domain, n })
}

/// Number of steps that all lanes take together. A walk is longer with a probability of 2⁻⁴⁰ at most.
const STEPS: u32 = 40;

/// The integers below a power of two.
#[derive(Clone, Copy)]
struct Domain {
    mask: u32,
    shift: u32,
}

impl Domain {
    /// The smallest domain that contains 0..n, for n ≥ 2.
    #[inline(always)]
    fn of(n: u32) -> Self {
        let mask = u32::MAX >> (n - 1).leading_zeros();
        Self { mask, shift: (mask.count_ones() / 2).max(1) }
    }

    /// A keyed bijection on the domain, composed of additions, odd multiplications and xor-shifts, each invertible under
    /// the mask. There are six rounds because with five, pairs of a domain of 8 or 16 are measurably uneven.
    #[inline(always)]
    fn scramble<W: Word>(self, mut x: W, [mut p, mut q]: [W; 2]) -> W {
        let mask = W::splat(self.mask);
        for _ in 0..6 {
            x = x.wrapping_add(p).wrapping_mul(q | W::splat(1)) & mask;
            x = x ^ (x >> self.shift);
            p = p.wrapping_mul(W::splat(0x9e37_79b1)) ^ q.rotate_left(13);
            q = q.wrapping_add(p.rotate_left(16));
        }
        x.wrapping_add(p) & mask
    }
}

/// Continues a walk to its end.
#[derive(Clone, Copy)]
struct Walk {
    domain: Domain,
    n: u32,
}

impl OfLane for Walk {
    fn of(self, mut x: u32, key: [u32; 2]) -> u32 {
        while x >= self.n {
            x = self.domain.scramble(x, key);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permute_is_a_bijection() {
        for n in [1, 2, 3, 5, 16, 17, 100, 1000, 4096] {
            for key in 0..8 {
                let mut seen = vec![false; n as usize];
                (0..n).for_each(|i| seen[permute(i, n, mix([key, 7])) as usize] = true);
                assert!(seen.iter().all(|&s| s), "n = {n}");
            }
        }
    }

    #[test]
    fn a_long_walk_ends_as_a_short_one() {
        let domain = Domain::of(1025);
        for i in 0..1025 {
            let key = mix([3, 4]);
            assert_eq!(Walk { domain, n: 1025 }.of(domain.scramble(i, key), key), permute(i, 1025, key));
        }
    }
}
