//! One lane: the kernel that runs on every machine.

use super::mask::Mask;
use super::real::{Double, Real, Word};
use super::sealed::Sealed;

impl Sealed for f32 {}
impl Sealed for f64 {}
impl Sealed for u32 {}
impl Sealed for bool {}

impl Mask for bool {
    const LANES: usize = 1;
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }
    #[inline(always)]
    fn from_bitmask(bits: u32) -> Self {
        bits & 1 != 0
    }
    #[inline(always)]
    fn bitmask(self) -> u32 {
        u32::from(self)
    }
}

/// The methods that read and write slices, which are the same for numbers and words.
macro_rules! memory {
    ($t:ty) => {
        #[inline(always)]
        fn load(from: &[$t]) -> Self {
            from.first().copied().unwrap_or_default()
        }
        #[inline(always)]
        fn load_where(mask: bool, from: &[$t]) -> Self {
            if mask { from.first().copied().unwrap_or_default() } else { Self::default() }
        }
        #[inline(always)]
        fn store(self, to: &mut [$t]) {
            if let Some(place) = to.first_mut() {
                *place = self;
            }
        }
        #[inline(always)]
        fn store_where(self, mask: bool, to: &mut [$t]) {
            if let (true, Some(place)) = (mask, to.first_mut()) {
                *place = self;
            }
        }
        #[inline(always)]
        fn compress_store(self, mask: bool, to: &mut [$t]) -> usize {
            // Written in any case, which needs no branch on the mask.
            match to.first_mut() {
                Some(place) => {
                    *place = self;
                    usize::from(mask)
                }
                None => 0,
            }
        }
        #[inline(always)]
        fn gather(table: &[$t], index: u32) -> Self {
            table.get(clamped(index, table.len())).copied().unwrap_or_default()
        }
        #[inline(always)]
        fn select(mask: bool, yes: Self, no: Self) -> Self {
            if mask { yes } else { no }
        }
    };
}

/// Index of the entry that a gather reads: the last one if `index` lies beyond the table. Indices stay below 2³¹, which
/// the instructions of the wide implementations take as signed.
#[inline(always)]
fn clamped(index: u32, len: usize) -> usize {
    (index as usize).min(len.saturating_sub(1)).min(i32::MAX as usize)
}

/// 2²³: from here on every f32 is an integer. Smaller positive numbers lose their fractions when it is added.
const INTEGERS: f32 = 8_388_608.0;

impl Real for f32 {
    const LANES: usize = 1;
    type Word = u32;
    type Mask = bool;
    type Double = f64;

    memory!(f32);

    #[inline(always)]
    fn splat(x: f32) -> Self {
        x
    }
    #[inline(always)]
    fn gather_rows(table: &[[f32; 4]], index: u32) -> [Self; 4] {
        table.get(clamped(index, table.len())).copied().unwrap_or_default()
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        f32::copysign(self, sign)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        let nearest = Real::round_ties_even(self);
        let below = if nearest > self { nearest - 1.0 } else { nearest };
        below.copysign(self)
    }
    #[inline(always)]
    fn round_ties_even(self) -> Self {
        // Without the instructions of SSE4.1 the methods of f32 are calls.
        let magnitude = f32::abs(self);
        let nearest = (magnitude + INTEGERS) - INTEGERS;
        if magnitude < INTEGERS { nearest.copysign(self) } else { self }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn to_bits(self) -> u32 {
        f32::to_bits(self)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        f32::from_bits(bits)
    }
    #[inline(always)]
    fn to_int(self) -> u32 {
        const END: f32 = 2_147_483_648.0;
        if self.abs() < END { self as i32 as u32 } else { 0x8000_0000 }
    }
}

impl Word for u32 {
    type Real = f32;
    type Mask = bool;

    memory!(u32);

    #[inline(always)]
    fn splat(x: u32) -> Self {
        x
    }
    #[inline(always)]
    fn lane_index() -> Self {
        0
    }
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        u32::wrapping_add(self, other)
    }
    #[inline(always)]
    fn wrapping_sub(self, other: Self) -> Self {
        u32::wrapping_sub(self, other)
    }
    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        u32::wrapping_mul(self, other)
    }
    #[inline(always)]
    fn rotate_left(self, n: u32) -> Self {
        u32::rotate_left(self, n)
    }
    #[inline(always)]
    fn reverse_bits(self) -> Self {
        u32::reverse_bits(self)
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn lt_signed(self, other: Self) -> bool {
        (self as i32) < other as i32
    }
    #[inline(always)]
    fn int_to_real(self) -> f32 {
        self as i32 as f32
    }
}

impl Double for f64 {
    type Real = f32;
    type Mask = bool;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn from_real(x: f32) -> Self {
        f64::from(x)
    }
    #[inline(always)]
    fn to_real(self) -> f32 {
        self as f32
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}
