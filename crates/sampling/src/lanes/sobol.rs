//! An Owen-scrambled (0,2)-sequence over words; `r` is always the index of a sample with its bits reversed.

use super::Keyx;
use dapple_math::lanes::{Real, Vec2x, Word};

/// A nested uniform scramble of bit-reversed numbers: x → m·x + c modulo 2³² with odd m.
///
/// Bit i of the result is bit i of `x`, flipped depending on the bits below it. For random m and c, two numbers that
/// first differ in bit i have results that agree below it up to common flips, differ in it, and are uniform and
/// independent above it, because the difference is a random odd multiple of 2ⁱ. This is the law of pairs under a nested
/// uniform scramble [Owen 1997], on which alone the variance of a mean depends.
#[derive(Clone, Copy)]
pub(crate) struct Scramble<W> {
    pub(crate) factor: W,
    pub(crate) shift: W,
}

impl<W: Word> Scramble<W> {
    #[inline(always)]
    pub(crate) fn new(factor: W, shift: W) -> Self {
        Self { factor: factor | W::splat(1), shift }
    }

    #[inline(always)]
    pub(crate) fn of(self, x: W) -> W {
        x.wrapping_mul(self.factor).wrapping_add(self.shift)
    }
}

/// Returns the scrambles of the index and of both coordinates. Only the low bits of factors and of the shifts of
/// coordinates, and the high bits of the shift of the index, matter for the first points: they are from different bits
/// of the key.
#[inline(always)]
fn scrambles<W: Word>(key: Keyx<W>) -> [Scramble<W>; 3] {
    let [a, b] = key.words();
    let c = (a ^ (b >> 16)).wrapping_mul(W::splat(0x9e37_79b1));
    [Scramble::new(a, b), Scramble::new(b, a >> 16), Scramble::new(c >> 16, c)]
}

/// Returns the second Sobol dimension of an index, bit-reversed. Its generator matrix is Pascal's triangle mod 2,
/// applied as a product of the factors (I + shift by 2^k) for k = 4..0.
#[inline(always)]
pub(crate) fn pascal_reversed<W: Word>(x: W) -> W {
    let x = x ^ (x >> 16);
    let x = x ^ ((x & W::splat(0xff00_ff00)) >> 8);
    let x = x ^ ((x & W::splat(0xf0f0_f0f0)) >> 4);
    let x = x ^ ((x & W::splat(0xcccc_cccc)) >> 2);
    x ^ ((x & W::splat(0xaaaa_aaaa)) >> 1)
}

/// Returns the reversed index of sample `r` of `n` where several integrals share the sample index: permuted by the key
/// within aligned blocks of 16 (or of the largest power of two up to n, if that is smaller), so that the points of two
/// pads are paired at random while blocks stay nets.
///
/// Any two indices of a block are mapped to any two positions with equal probability by x → a·x + c over the field of 16
/// elements (or 8, 4, 2; modulus x^b + x + 1). This alone makes the variance of a paired sum that of a random pairing. It
/// is followed by x → m·x + k mod 16, so that two orders are not linear maps of each other. n only has an effect below
/// 16, so that a render can be continued with a larger n.
#[inline(always)]
pub fn pad<W: Word>(r: W, n: u32, key: Keyx<W>) -> W {
    match n {
        0 | 1 => r,
        2..16 => pad_block(r, n.ilog2(), key),
        _ => pad_block(r, 4, key),
    }
}

/// Permutes within blocks of 2^bits, whose place is the highest bits of `r` and whose number is the others.
#[inline(always)]
fn pad_block<W: Word>(r: W, bits: u32, key: Keyx<W>) -> W {
    // A hash x → m·x + c of the number of the block, whose values for two blocks are independent over the keys.
    let [a, b] = key.words();
    let block = r << bits;
    let h = (block ^ (block >> 16)).wrapping_mul((a ^ b.rotate_left(16)) | W::splat(1)).wrapping_add(b);
    // One of the 2^bits − 1 factors, by the highest byte; the other two numbers are from other bits.
    let factor = ((h >> 24).wrapping_mul(W::splat((1 << bits) - 1)) >> 4) & W::splat(0xf0);
    let product = W::gather(&PRODUCTS[bits as usize - 1], factor | (r >> (32 - bits)));
    // Whatever is below the highest bits is the same in the whole block, and so is the carry from it.
    let place = (product ^ (h << 8)).wrapping_mul((h >> 16) | W::splat(1));
    let below = W::splat(u32::MAX >> bits);
    (place & !below) | (r & below)
}

/// Products in the fields of 2, 4, 8 and 16 elements: entry 16·(a − 1) + x is a·x in the highest bits of a word.
static PRODUCTS: [[u32; 256]; 4] = products();

const fn products() -> [[u32; 256]; 4] {
    let mut all = [[0; 256]; 4];
    let mut i = 0;
    while i < 4 * 256 {
        let (bits, entry) = (i as u32 / 256 + 1, i as u32 % 256);
        let (a, x) = (entry / 16 + 1, entry % 16);
        if a < 1 << bits && x < 1 << bits {
            all[i / 256][entry as usize] = times(a, x, bits) << (32 - bits);
        }
        i += 1;
    }
    all
}

/// Returns the product in the field of 2^bits elements, bits ≤ 4.
const fn times(a: u32, x: u32, bits: u32) -> u32 {
    let (mut p, mut i) = (0, 0);
    while i < 4 {
        p ^= (a << i) & (x >> i & 1).wrapping_neg();
        i += 1;
    }
    // x^b = x + 1. The high part has at most 3 bits, so that one reduction is enough.
    let high = p >> bits;
    (p ^ high ^ (high << 1)) & ((1 << bits) - 1)
}

/// Returns the one-dimensional point `r` in units of 2⁻³².
#[inline(always)]
pub fn bits_1d<W: Word>(r: W, key: Keyx<W>) -> W {
    let [index, x, _] = scrambles(key);
    x.of(index.of(r).reverse_bits()).reverse_bits()
}

/// Returns the two-dimensional point `r` in units of 2⁻³².
#[inline(always)]
pub fn bits_2d<W: Word>(r: W, key: Keyx<W>) -> [W; 2] {
    let [index, x, y] = scrambles(key);
    // Dimension 0 is the reversed index, and a scramble lies between two reversals, so that the inner ones cancel.
    let index = index.of(r).reverse_bits();
    reverse_both([x.of(index), y.of(pascal_reversed(index))])
}

/// Reverses the bits of two words; those of a single lane are reversed together.
#[inline(always)]
fn reverse_both<W: Word>([x, y]: [W; 2]) -> [W; 2] {
    if W::Real::LANES > 1 {
        return [x.reverse_bits(), y.reverse_bits()];
    }
    let mut lanes = [[0; 1]; 2];
    x.store(&mut lanes[0]);
    y.store(&mut lanes[1]);
    let both = (u64::from(lanes[1][0]) | u64::from(lanes[0][0]) << 32).reverse_bits();
    [W::splat(both as u32), W::splat((both >> 32) as u32)]
}

/// Returns point `r` in [0,1), a multiple of 2⁻²⁴.
#[inline(always)]
pub fn point_1d<W: Word>(r: W, key: Keyx<W>) -> W::Real {
    bits_1d(r, key).unit()
}

/// Returns point `r` in [0,1)², with coordinates that are multiples of 2⁻²⁴.
#[inline(always)]
pub fn point_2d<W: Word>(r: W, key: Keyx<W>) -> Vec2x<W::Real> {
    let [x, y] = bits_2d(r, key);
    Vec2x::new(x.unit(), y.unit())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 7·9 in the field of 16: (x²+x+1)(x³+1) = x^5+x^4+x³+x²+x+1 = (x²+x)+(x+1)+x³+x²+x+1 = x³+x.
    #[test]
    fn products_are_those_of_the_field() {
        assert_eq!(times(7, 9, 4), 10);
        assert_eq!(PRODUCTS[3][6 * 16 + 9], 10 << 28);
    }
}
