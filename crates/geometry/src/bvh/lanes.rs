//! Eight floats at a time. Every operation is one IEEE operation per lane in every implementation (no fused
//! multiply-add), so all of them give the same bits.

use super::simd::Stack;

/// Eight lanes. `min` and `max` return the second operand when either is NaN; comparisons give one bit per lane and
/// are false for NaN.
pub(super) trait Lanes: Copy {
    fn splat(x: f32) -> Self;
    fn load(x: &[f32; 8]) -> Self;
    fn store(self, to: &mut [f32; 8]);
    fn add(self, o: Self) -> Self;
    fn sub(self, o: Self) -> Self;
    fn mul(self, o: Self) -> Self;
    fn div(self, o: Self) -> Self;
    fn abs(self) -> Self;
    /// self < o ? self : o
    fn min(self, o: Self) -> Self;
    /// self > o ? self : o
    fn max(self, o: Self) -> Self;
    fn lt(self, o: Self) -> u32;
    fn le(self, o: Self) -> u32;
    /// Pushes the children entered, self ≤ `far` (the lanes of `mask`), the farthest first. `self` are entry distances
    /// (≥ 0, never NaN); on the stack, and in the order, the lane stands in place of their lowest three bits.
    fn push_sorted(self, far: Self, mask: u32, child: &[u32; 8], stack: &mut Stack);
}

/// Plain arrays, which the compiler may turn into whatever the machine has.
#[derive(Clone, Copy)]
pub(super) struct Portable(pub [f32; 8]);

macro_rules! lanewise {
    ($name:ident, $a:ident, $b:ident, $value:expr) => {
        #[inline(always)]
        fn $name(self, o: Self) -> Self {
            let mut result = [0.0; 8];
            for i in 0..8 {
                let ($a, $b) = (self.0[i], o.0[i]);
                result[i] = $value;
            }
            Self(result)
        }
    };
}

macro_rules! mask {
    ($name:ident, $op:tt) => {
        #[inline(always)]
        fn $name(self, o: Self) -> u32 {
            let mut mask = 0;
            for i in 0..8 {
                mask |= u32::from(self.0[i] $op o.0[i]) << i;
            }
            mask
        }
    };
}

impl Lanes for Portable {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; 8])
    }
    #[inline(always)]
    fn load(x: &[f32; 8]) -> Self {
        Self(*x)
    }
    #[inline(always)]
    fn store(self, to: &mut [f32; 8]) {
        *to = self.0;
    }
    lanewise!(add, a, b, a + b);
    lanewise!(sub, a, b, a - b);
    lanewise!(mul, a, b, a * b);
    lanewise!(div, a, b, a / b);
    lanewise!(min, a, b, if a < b { a } else { b });
    lanewise!(max, a, b, if a > b { a } else { b });
    mask!(lt, <);
    mask!(le, <=);
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn push_sorted(self, _far: Self, mask: u32, child: &[u32; 8], stack: &mut Stack) {
        push_sorted(&self.0, mask, child, stack);
    }
}

/// [`Lanes::push_sorted`] one lane after the other.
#[inline(always)]
pub(super) fn push_sorted(near: &[f32; 8], mut mask: u32, child: &[u32; 8], stack: &mut Stack) {
    let base = stack.len();
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & 7;
        mask &= mask - 1;
        stack.insert(base, (near[lane].to_bits() & !7) | lane as u32, child[lane]);
    }
}
