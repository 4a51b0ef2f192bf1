//! Masks: one truth value per lane.

use super::sealed::Sealed;
use std::fmt::Debug;
use std::ops::{BitAnd, BitOr, BitXor, Not};

/// One truth value per lane, as comparisons give and `select` takes.
pub trait Mask:
    Sealed
    + Copy
    + Debug
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Not<Output = Self>
{
    /// Number of lanes.
    const LANES: usize;

    /// Gives every lane the same value.
    fn splat(value: bool) -> Self;

    /// Builds the mask whose lane i is bit i; bits beyond the lanes are ignored.
    fn from_bitmask(bits: u32) -> Self;

    /// Returns the lanes as bits: bit i is lane i, and all higher bits are 0.
    fn bitmask(self) -> u32;

    /// Builds the mask of the first `n` lanes, or of all of them if there are fewer.
    #[inline(always)]
    fn first(n: usize) -> Self {
        if n >= Self::LANES { Self::splat(true) } else { Self::from_bitmask((1 << n) - 1) }
    }

    /// Whether any lane is true.
    #[inline(always)]
    fn any(self) -> bool {
        self.bitmask() != 0
    }

    /// Whether every lane is true.
    #[inline(always)]
    fn all(self) -> bool {
        !(!self).any()
    }

    /// Returns the number of true lanes.
    #[inline(always)]
    fn count(self) -> usize {
        self.bitmask().count_ones() as usize
    }
}
