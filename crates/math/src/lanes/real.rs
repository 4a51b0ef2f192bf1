//! Numbers and words of one lane or of many: what every formula of the batched code is written over.

use super::mask::Mask;
use super::sealed::Sealed;
use std::fmt::Debug;
use std::ops::{
    Add, AddAssign, BitAnd, BitOr, BitXor, Div, Mul, MulAssign, Neg, Not, Shl, Shr, Sub, SubAssign,
};

/// The largest number of lanes of any implementation.
pub const MAX_LANES: usize = 16;

/// `LANES` numbers in f32.
///
/// Every operation is the same correctly rounded IEEE operation, or the same integer operation, in each lane of each
/// implementation. A formula over `Real` therefore gives the same bits whatever the number of lanes. Only the sign and
/// the payload of a NaN are unspecified; whether a result is NaN is not. There is no fused multiply-add and no
/// approximate reciprocal.
///
/// The trait is meant for generic code. On a plain `f32` the inherent methods of the same name have priority, and
/// `f32::min` and `f32::max` treat NaN differently.
pub trait Real:
    Sealed
    + Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// Number of lanes.
    const LANES: usize;

    /// As many 32-bit integers.
    type Word: Word<Real = Self, Mask = Self::Mask>;

    /// As many truth values.
    type Mask: Mask;

    /// As many numbers in f64.
    type Double: Double<Real = Self, Mask = Self::Mask>;

    /// Gives every lane the same number.
    fn splat(x: f32) -> Self;

    /// Reads the first `LANES` numbers of a slice. If there are fewer, the other lanes are 0.
    fn load(from: &[f32]) -> Self;

    /// Reads the lanes of `mask`, lane i from place i; the other lanes, and those beyond the slice, are 0.
    fn load_where(mask: Self::Mask, from: &[f32]) -> Self;

    /// Writes lane i to place i of a slice, as far as the slice reaches.
    fn store(self, to: &mut [f32]);

    /// Writes the lanes of `mask`, lane i to place i, as far as the slice reaches. Other places keep their values.
    fn store_where(self, mask: Self::Mask, to: &mut [f32]);

    /// Packs the lanes of `mask` in order to the front of a slice, as far as it reaches, and returns the number of
    /// places that now hold them. The following places below `LANES` may be overwritten with any values.
    fn compress_store(self, mask: Self::Mask, to: &mut [f32]) -> usize;

    /// Returns `table[index]` per lane. An index beyond the table reads its last entry; an empty table gives 0.
    fn gather(table: &[f32], index: Self::Word) -> Self;

    /// Returns the four numbers of `table[index]` per lane, as columns. Indices are clamped as in [`Real::gather`].
    /// Several numbers of one record are read faster in this way than by one gather each.
    fn gather_rows(table: &[[f32; 4]], index: Self::Word) -> [Self; 4];

    /// Returns `yes` in the lanes of `mask` and `no` in the others.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Returns `self < other ? self : other`: `other` if either is NaN, and `other` for zeros of both signs.
    fn min(self, other: Self) -> Self;

    /// Returns `self > other ? self : other`: `other` if either is NaN, and `other` for zeros of both signs.
    fn max(self, other: Self) -> Self;

    /// Clears the sign.
    fn abs(self) -> Self;

    /// Returns the magnitude of `self` with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;

    /// Returns the square root, correctly rounded; NaN below 0.
    fn sqrt(self) -> Self;

    /// Returns the largest integer not above `self`, with the sign of `self`.
    fn floor(self) -> Self;

    /// Returns the nearest integer, halves to the even one, with the sign of `self`.
    fn round_ties_even(self) -> Self;

    /// Whether `self < other`; false for NaN.
    fn lt(self, other: Self) -> Self::Mask;

    /// Whether `self ≤ other`; false for NaN.
    fn le(self, other: Self) -> Self::Mask;

    /// Whether `self = other`; false for NaN.
    fn eq(self, other: Self) -> Self::Mask;

    /// Whether `self > other`; false for NaN.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }

    /// Whether `self ≥ other`; false for NaN.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }

    /// Whether `self ≠ other`; true for NaN.
    #[inline(always)]
    fn ne(self, other: Self) -> Self::Mask {
        !self.eq(other)
    }

    /// Whether the number is neither infinite nor NaN.
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        self.abs().lt(Self::splat(f32::INFINITY))
    }

    /// Returns the bits of the numbers.
    fn to_bits(self) -> Self::Word;

    /// Returns the numbers with the given bits.
    fn from_bits(bits: Self::Word) -> Self;

    /// Returns the integer part as a two's complement word, rounded towards zero. It is 0x8000_0000 for NaN and outside
    /// of −2³¹ ≤ x < 2³¹.
    fn to_int(self) -> Self::Word;
}

/// `LANES` unsigned 32-bit integers, with wrapping arithmetic.
///
/// Shifts are by the same number of bits in every lane, less than 32.
pub trait Word:
    Sealed
    + Copy
    + Debug
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Not<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// As many numbers.
    type Real: Real<Word = Self, Mask = Self::Mask>;

    /// As many truth values.
    type Mask: Mask;

    /// Gives every lane the same word.
    fn splat(x: u32) -> Self;

    /// Returns the index of each lane: 0, 1, 2, …
    fn lane_index() -> Self;

    /// Reads words as [`Real::load`] reads numbers.
    fn load(from: &[u32]) -> Self;

    /// Reads words as [`Real::load_where`] reads numbers.
    fn load_where(mask: Self::Mask, from: &[u32]) -> Self;

    /// Writes words as [`Real::store`] writes numbers.
    fn store(self, to: &mut [u32]);

    /// Writes words as [`Real::store_where`] writes numbers.
    fn store_where(self, mask: Self::Mask, to: &mut [u32]);

    /// Packs words as [`Real::compress_store`] packs numbers.
    fn compress_store(self, mask: Self::Mask, to: &mut [u32]) -> usize;

    /// Reads words as [`Real::gather`] reads numbers.
    fn gather(table: &[u32], index: Self) -> Self;

    /// Returns `yes` in the lanes of `mask` and `no` in the others.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Adds modulo 2³².
    fn wrapping_add(self, other: Self) -> Self;

    /// Subtracts modulo 2³².
    fn wrapping_sub(self, other: Self) -> Self;

    /// Multiplies modulo 2³².
    fn wrapping_mul(self, other: Self) -> Self;

    /// Rotates by `n` bits modulo 32 towards the highest bit.
    fn rotate_left(self, n: u32) -> Self;

    /// Reverses the order of the 32 bits.
    fn reverse_bits(self) -> Self;

    /// Whether the words are equal.
    fn eq(self, other: Self) -> Self::Mask;

    /// Whether `self < other` as unsigned integers.
    fn lt(self, other: Self) -> Self::Mask;

    /// Whether `self < other` as integers in two's complement.
    fn lt_signed(self, other: Self) -> Self::Mask;

    /// Whether the words differ.
    #[inline(always)]
    fn ne(self, other: Self) -> Self::Mask {
        !self.eq(other)
    }

    /// Whether `self ≤ other` as unsigned integers.
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        !other.lt(self)
    }

    /// Returns the value of a two's complement integer, rounded to nearest, halves to even.
    fn int_to_real(self) -> Self::Real;

    /// Returns the value of an unsigned integer, rounded to nearest, halves to even.
    #[inline(always)]
    fn to_real(self) -> Self::Real {
        // Both halves are exact in f32, so that only the sum is rounded.
        let high = (self >> 16).int_to_real() * Self::Real::splat(65_536.0);
        high + (self & Self::splat(0xffff)).int_to_real()
    }

    /// Returns a number in [0, 1) from the highest 24 bits: ⌊word / 2⁸⌋ / 2²⁴. It is exact, and never 1.
    #[inline(always)]
    fn unit(self) -> Self::Real {
        (self >> 8).int_to_real() * Self::Real::splat(1.0 / 16_777_216.0)
    }
}

/// `LANES` numbers in f64, for the few formulas whose rounding in f32 is too large. They take twice as many registers.
///
/// Operations are those of IEEE, as in [`Real`].
pub trait Double:
    Sealed + Copy + Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// As many numbers in f32.
    type Real: Real<Double = Self, Mask = Self::Mask>;

    /// As many truth values.
    type Mask: Mask;

    /// Gives every lane the same number.
    fn splat(x: f64) -> Self;

    /// Returns the same numbers in f64.
    fn from_real(x: Self::Real) -> Self;

    /// Rounds to the nearest numbers in f32.
    fn to_real(self) -> Self::Real;

    /// Returns `self > other ? self : other`, as [`Real::max`] does.
    fn max(self, other: Self) -> Self;

    /// Clears the sign.
    fn abs(self) -> Self;

    /// Returns the square root, correctly rounded; NaN below 0.
    fn sqrt(self) -> Self;

    /// Whether `self < other`; false for NaN.
    fn lt(self, other: Self) -> Self::Mask;

    /// Returns `yes` in the lanes of `mask` and `no` in the others.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
}
