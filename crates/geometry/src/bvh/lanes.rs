//! Operations on floats in lanes: on the eight boxes or triangles that one ray meets ([`Lanes`]), and on one number of
//! each of several rays ([`Real`]). Every operation is one IEEE operation per lane in every implementation (no fused
//! multiply-add), so that all implementations give identical bits.

use super::node::{Child, Children};
use super::stack::Stack;
use dapple_math::lanes::{Mask, Real};

/// Arithmetic. `min` and `max` return the second operand when either is NaN; comparisons are false for NaN.
pub(super) trait Floats: Copy {
    /// One truth value per lane.
    type Mask: Copy;
    fn splat(x: f32) -> Self;
    fn add(self, o: Self) -> Self;
    fn sub(self, o: Self) -> Self;
    fn mul(self, o: Self) -> Self;
    fn div(self, o: Self) -> Self;
    fn abs(self) -> Self;
    /// self < o ? self : o
    fn min(self, o: Self) -> Self;
    /// self > o ? self : o
    fn max(self, o: Self) -> Self;
    fn lt(self, o: Self) -> Self::Mask;
    fn le(self, o: Self) -> Self::Mask;
    fn eq(self, o: Self) -> Self::Mask;
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Whether any lane is true.
    fn any(mask: Self::Mask) -> bool;
}

/// What the masks of eight lanes, one bit each, have in common.
macro_rules! bits {
    () => {
        type Mask = u32;
        #[inline(always)]
        fn both(a: u32, b: u32) -> u32 {
            a & b
        }
        #[inline(always)]
        fn either(a: u32, b: u32) -> u32 {
            a | b
        }
        #[inline(always)]
        fn any(mask: u32) -> bool {
            mask != 0
        }
    };
}
pub(super) use bits;

/// Eight lanes. Masks have one bit per lane.
pub(super) trait Lanes: Floats<Mask = u32> {
    fn load(x: &[f32; 8]) -> Self;
    fn store(self, to: &mut [f32; 8]);
    #[inline(always)]
    fn array(self) -> [f32; 8] {
        let mut array = [0.0; 8];
        self.store(&mut array);
        array
    }
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
    /// Returns the nearest entered child (self < `far`) and puts the other entered children on the stack, the farthest
    /// first. `self` contains the entry distances (≥ 0, never NaN). On the stack and for the order, the lane index
    /// replaces their lowest three bits. `ahead` is called with the child that will be popped next.
    fn nearest(self, far: Self, child: &Children, stack: &mut Stack, ahead: impl Fn(Child)) -> Option<Child>;
    /// Returns one of the entered children (self < `far`) and puts the others on the stack, without distances. `ahead`
    /// is called with the child that will be popped next.
    #[inline(always)]
    fn first(self, far: Self, child: &Children, stack: &mut Stack, _: impl Fn(Child)) -> Option<Child> {
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

impl Floats for Portable {
    bits!();
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; 8])
    }
    lanewise!(add, a, b, a + b);
    lanewise!(sub, a, b, a - b);
    lanewise!(mul, a, b, a * b);
    lanewise!(div, a, b, a / b);
    lanewise!(min, a, b, if a < b { a } else { b });
    lanewise!(max, a, b, if a > b { a } else { b });
    mask!(lt, <);
    mask!(le, <=);
    mask!(eq, ==);
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
}

impl Lanes for Portable {
    #[inline(always)]
    fn load(x: &[f32; 8]) -> Self {
        Self(*x)
    }
    #[inline(always)]
    fn store(self, to: &mut [f32; 8]) {
        *to = self.0;
    }
    #[inline(always)]
    fn nearest(self, far: Self, child: &Children, stack: &mut Stack, _: impl Fn(Child)) -> Option<Child> {
        nearest(&self.0, self.lt(far), child, stack)
    }
}

macro_rules! of_real {
    ($($name:ident),*) => {$(
        #[inline(always)]
        fn $name(self, o: Self) -> Self {
            Self(self.0.$name(o.0))
        }
    )*};
}

/// One number of each of several rays.
#[derive(Clone, Copy)]
pub(super) struct PerRay<R>(pub R);

impl<R: Real> Floats for PerRay<R> {
    type Mask = R::Mask;
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(R::splat(x))
    }
    of_real!(add, sub, mul, div, min, max);
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn lt(self, o: Self) -> R::Mask {
        self.0.lt(o.0)
    }
    #[inline(always)]
    fn le(self, o: Self) -> R::Mask {
        self.0.le(o.0)
    }
    #[inline(always)]
    fn eq(self, o: Self) -> R::Mask {
        self.0.eq(o.0)
    }
    #[inline(always)]
    fn both(a: R::Mask, b: R::Mask) -> R::Mask {
        a & b
    }
    #[inline(always)]
    fn either(a: R::Mask, b: R::Mask) -> R::Mask {
        a | b
    }
    #[inline(always)]
    fn any(mask: R::Mask) -> bool {
        mask.any()
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
