//! Integer arithmetic over words that instruction sets do not have.

use dapple_math::lanes::{MAX_LANES, Mask, Real, Word};

/// A function of single lanes, of a word and of a key.
pub trait OfLane: Copy {
    /// Returns the word of one lane.
    fn of(self, x: u32, key: [u32; 2]) -> u32;
}

/// Replaces the lanes of `mask` in `x` by a function of them. The lanes are expected to be few or none.
#[inline(always)]
pub fn by_lane<W: Word>(mask: W::Mask, x: W, key: [W; 2], f: impl OfLane) -> W {
    if !mask.any() {
        return x;
    }
    let (mut xs, mut a, mut b) = ([0; MAX_LANES], [0; MAX_LANES], [0; MAX_LANES]);
    x.store(&mut xs);
    key[0].store(&mut a);
    key[1].store(&mut b);
    replace_lanes(mask.bitmask(), &mut xs, &a, &b, f);
    W::load(&xs)
}

#[cold]
#[inline(never)]
fn replace_lanes(
    mask: u32,
    xs: &mut [u32; MAX_LANES],
    a: &[u32; MAX_LANES],
    b: &[u32; MAX_LANES],
    f: impl OfLane,
) {
    for (lane, x) in xs.iter_mut().enumerate() {
        if mask >> lane & 1 == 1 {
            *x = f.of(*x, [a[lane], b[lane]]);
        }
    }
}

/// Returns ⌊x / n⌋ and the remainder, exactly. A divisor of 0 counts as 1.
#[inline(always)]
pub fn divide<W: Word>(x: W, n: u32) -> (W, W) {
    let n = n.max(1);
    let zero = W::splat(0);
    if x.lt(W::splat(n)).all() {
        return (zero, x);
    }
    if W::Real::LANES == 1 {
        let mut lane = [0];
        x.store(&mut lane);
        return (W::splat(lane[0] / n), W::splat(lane[0] % n));
    }
    if n.is_power_of_two() {
        return (x >> n.trailing_zeros(), x & W::splat(n - 1));
    }
    if n >= 1 << 30 {
        // The quotient is at most 3.
        let (mut q, mut rest) = (zero, x);
        for _ in 0..3 {
            let more = W::splat(n).le(rest);
            q = W::select(more, q.wrapping_add(W::splat(1)), q);
            rest = W::select(more, rest.wrapping_sub(W::splat(n)), rest);
        }
        return (q, rest);
    }
    let reciprocal = 1.0 / n as f32;
    // The quotient in f32 is off by less than 2⁻²² of itself and 1, so that the remainder is below 2³¹ in magnitude.
    let q = (x.to_real() * W::Real::splat(reciprocal)).to_int();
    let rest = x.wrapping_sub(q.wrapping_mul(W::splat(n)));
    settle(q, rest, n, reciprocal)
}

/// Adjusts a quotient so that the signed remainder, whose magnitude is below 2³¹, is in 0..n.
#[inline(always)]
pub fn settle<W: Word>(q: W, rest: W, n: u32, reciprocal: f32) -> (W, W) {
    let (n, one, zero) = (W::splat(n), W::splat(1), W::splat(0));
    let more = (rest.int_to_real() * W::Real::splat(reciprocal)).to_int();
    let (q, rest) = (q.wrapping_add(more), rest.wrapping_sub(more.wrapping_mul(n)));
    let below = rest.lt_signed(zero);
    let q = W::select(below, q.wrapping_sub(one), q);
    let rest = W::select(below, rest.wrapping_add(n), rest);
    let above = !rest.lt_signed(n);
    (W::select(above, q.wrapping_add(one), q), W::select(above, rest.wrapping_sub(n), rest))
}

/// Returns the higher word of the product of two unsigned words.
#[inline(always)]
pub fn multiply_high<W: Word>(a: W, b: W) -> W {
    if W::Real::LANES == 1 {
        let (mut x, mut y) = ([0], [0]);
        a.store(&mut x);
        b.store(&mut y);
        return W::splat(((u64::from(x[0]) * u64::from(y[0])) >> 32) as u32);
    }
    let low = W::splat(0xffff);
    let (a_low, a_high, b_low, b_high) = (a & low, a >> 16, b & low, b >> 16);
    // No sum overflows: (2¹⁶ − 1)² + 2·(2¹⁶ − 1) < 2³².
    let middle = a_high.wrapping_mul(b_low).wrapping_add(a_low.wrapping_mul(b_low) >> 16);
    let other = a_low.wrapping_mul(b_high).wrapping_add(middle & low);
    a_high.wrapping_mul(b_high).wrapping_add(middle >> 16).wrapping_add(other >> 16)
}
