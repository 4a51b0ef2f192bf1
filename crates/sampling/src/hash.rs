//! Integer hashes, which are the same in all versions and on all machines.

/// Hashes 64 bits with full avalanche: the finaliser of SplitMix64 [Steele, Lea, Flood 2014].
#[inline]
pub(crate) const fn mix64(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// Returns the 24 high bits as a float in [0, 1), because `u32 / 2^32` could round up to 1.
#[inline]
pub(crate) fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Permutes i < n by the bijection on 0..n that `key` selects, with cycle walking over the next power of two [Kensler
/// 2013, in spirit].
#[inline]
pub(crate) fn permute(i: u32, n: u32, key: u64) -> u32 {
    if n <= 1 {
        return 0;
    }
    let mask = u32::MAX >> (n - 1).leading_zeros();
    let bits = mask.count_ones();
    let mut x = i;
    loop {
        x = scramble(x, mask, bits, key);
        if x < n {
            return x;
        }
    }
}

/// A keyed bijection on the low `bits` bits, composed of additions, odd multiplications and xor-shifts, each invertible
/// under the mask. There are six rounds because with five, pairs of a domain of 8 or 16 are measurably uneven.
#[inline]
fn scramble(mut x: u32, mask: u32, bits: u32, mut key: u64) -> u32 {
    let shift = (bits / 2).max(1);
    for _ in 0..6 {
        x = x.wrapping_add(key as u32) & mask;
        x = x.wrapping_mul((key >> 32) as u32 | 1) & mask;
        x ^= x >> shift;
        key = key.rotate_left(23).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
    x.wrapping_add(key as u32) & mask
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permute_is_a_bijection() {
        for n in [1, 2, 3, 5, 16, 17, 100, 1000, 4096] {
            for key in 0..8 {
                let mut seen = vec![false; n as usize];
                (0..n).for_each(|i| seen[permute(i, n, mix64(key)) as usize] = true);
                assert!(seen.iter().all(|&s| s), "n = {n}");
            }
        }
    }

    #[test]
    fn unit_is_below_one() {
        assert!(unit(u32::MAX) < 1.0);
        assert_eq!(unit(0), 0.0);
    }
}
