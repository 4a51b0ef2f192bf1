//! Operations on eight floats. Every operation is one IEEE operation per lane in every implementation (no fused
//! multiply-add), so that all implementations give identical bits.

use super::node::{Child, Children};
use super::stack::Stack;

/// Eight lanes. `min` and `max` return the second operand when either is NaN; comparisons give one bit per lane and
/// are false for NaN.
pub(super) trait Lanes: Copy {
    fn splat(x: f32) -> Self;
    fn load(x: &[f32; 8]) -> Self;
    fn store(self, to: &mut [f32; 8]);
    #[inline(always)]
    fn array(self) -> [f32; 8] {
        let mut array = [0.0; 8];
        self.store(&mut array);
        array
    }
    fn add(self, o: Self) -> Self;
    fn sub(self, o: Self) -> Self;
    fn mul(self, o: Self) -> Self;
    fn div(self, o: Self) -> Self;
    fn abs(self) -> Self;
    /// self < o ? self : o
    fn min(self, o: Self) -> Self;
    /// self > o ? self : o
    fn max(self, o: Self) -> Self;
    /// As `max` if either operand is ≥ 0; otherwise any value below 0.
    #[inline(always)]
    fn later(self, o: Self) -> Self {
        self.max(o)
    }
    /// As `min` if both operands are ≥ 0; otherwise any value below 0.
    #[inline(always)]
    fn earlier(self, o: Self) -> Self {
        self.min(o)
    }
    fn lt(self, o: Self) -> u32;
    fn le(self, o: Self) -> u32;
    /// Returns the nearest entered child (self < `far`) and puts the other entered children on the stack, the farthest
    /// first. `self` contains the entry distances (≥ 0, never NaN). On the stack and for the order, the lane index
    /// replaces their lowest three bits. `ahead` is called with the child that will be popped next.
    fn nearest(self, far: Self, child: &Children, stack: &mut Stack, ahead: impl Fn(Child)) -> Option<Child>;
    /// Returns one of the entered children (self < `far`) and puts the others on the stack, without distances. `ahead`
    /// is called with the child that will be popped next.
    #[inline(always)]
    fn any(self, far: Self, child: &Children, stack: &mut Stack, _: impl Fn(Child)) -> Option<Child> {
        let mut mask = self.lt(far);
        let first = lowest(mask, child)?;
        mask &= mask - 1;
        while mask != 0 {
            stack.push(child[mask.trailing_zeros() as usize & 7]);
            mask &= mask - 1;
        }
        Some(first)
    }
}

/// Plain arrays, which the compiler may vectorise.
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
    fn nearest(self, far: Self, child: &Children, stack: &mut Stack, _: impl Fn(Child)) -> Option<Child> {
        nearest(&self.0, self.lt(far), child, stack)
    }
}

/// The child in the lowest lane of `mask`.
#[inline(always)]
pub(super) fn lowest(mask: u32, child: &Children) -> Option<Child> {
    (mask != 0).then(|| child[mask.trailing_zeros() as usize & 7])
}

/// [`Lanes::nearest`], implemented one lane at a time.
#[inline(always)]
pub(super) fn nearest(near: &[f32; 8], mut mask: u32, child: &Children, stack: &mut Stack) -> Option<Child> {
    if mask & mask.wrapping_sub(1) == 0 {
        return lowest(mask, child);
    }
    let base = stack.len();
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & 7;
        mask &= mask - 1;
        stack.insert(base, (near[lane].to_bits() & !7) | lane as u32, child[lane]);
    }
    stack.pop().map(|(_, child)| child)
}
