//! Eight lanes in the registers of AVX2.
//!
//! All methods are `inline(always)` and become their instructions inside a function that is compiled for AVX2.
//!
//! Safety: code outside of `lanes` cannot name the types, and `dispatch` alone chooses them, where the machine has
//! AVX2, BMI1, BMI2 and POPCNT. Instructions of these sets can therefore be executed wherever a method is
//! called. Further conditions, on pointers, are stated beside the code.
#![allow(unsafe_code)]

use super::avx2_double::Avx2Double;
use super::double::double;
use super::mask::Mask;
use super::packed::PACKED;
use super::real::{Double, Real, Word};
use super::sealed::Sealed;
use std::arch::x86_64::*;
use std::ops::*;

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Avx2(__m256);

/// Eight words.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Avx2Word(__m256i);

/// Eight truth values, each as 32 equal bits.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Avx2Mask(__m256);

impl Sealed for Avx2 {}
impl Sealed for Avx2Word {}
impl Sealed for Avx2Mask {}

/// Methods of two operands, or operators with their traits, each of one instruction.
macro_rules! binary {
    ($($name:ident $instruction:ident),*) => {$(
        #[inline(always)]
        fn $name(self, other: Self) -> Self {
            // SAFETY: see the head of the file.
            unsafe { Self($instruction(self.0, other.0)) }
        }
    )*};
    ($t:ident: $($operator:ident $name:ident $instruction:ident),*) => {$(
        impl $operator for $t {
            type Output = Self;
            binary!($name $instruction);
        }
    )*};
}

binary!(Avx2: Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps);
binary!(Avx2Word: BitAnd bitand _mm256_and_si256, BitOr bitor _mm256_or_si256, BitXor bitxor _mm256_xor_si256);
binary!(Avx2Mask: BitAnd bitand _mm256_and_ps, BitOr bitor _mm256_or_ps, BitXor bitxor _mm256_xor_ps);

macro_rules! assign {
    ($($operator:ident $name:ident $with:tt),*) => {$(
        impl $operator for Avx2 {
            #[inline(always)]
            fn $name(&mut self, other: Self) {
                *self = *self $with other;
            }
        }
    )*};
}
assign!(AddAssign add_assign +, SubAssign sub_assign -, MulAssign mul_assign *);

impl Neg for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::from_bits(self.to_bits() ^ Avx2Word::splat(0x8000_0000))
    }
}

impl Not for Avx2Word {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        self ^ Self::splat(u32::MAX)
    }
}

impl Not for Avx2Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        self ^ Self::splat(true)
    }
}

impl Shl<u32> for Avx2Word {
    type Output = Self;
    #[inline(always)]
    fn shl(self, n: u32) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_sll_epi32(self.0, _mm_cvtsi32_si128(n as i32))) }
    }
}

impl Shr<u32> for Avx2Word {
    type Output = Self;
    #[inline(always)]
    fn shr(self, n: u32) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_srl_epi32(self.0, _mm_cvtsi32_si128(n as i32))) }
    }
}

impl Mask for Avx2Mask {
    const LANES: usize = 8;
    #[inline(always)]
    fn splat(value: bool) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_castsi256_ps(_mm256_set1_epi32(-i32::from(value)))) }
    }
    #[inline(always)]
    fn from_bitmask(bits: u32) -> Self {
        // SAFETY: see the head of the file.
        let lane = unsafe { Avx2Word(_mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128)) };
        (Avx2Word::splat(bits) & lane).eq(lane)
    }
    #[inline(always)]
    fn bitmask(self) -> u32 {
        // SAFETY: see the head of the file.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
    #[inline(always)]
    fn first(n: usize) -> Self {
        Avx2Word::lane_index().lt_signed(Avx2Word::splat(n.min(8) as u32))
    }
}

impl Avx2Word {
    /// Moves the lanes of `mask` to the front.
    #[inline(always)]
    fn packed(self, mask: Avx2Mask) -> Self {
        let order = &PACKED[mask.bitmask() as usize & 255];
        // SAFETY: reads the 8 bytes of the row; otherwise see the head of the file.
        unsafe {
            let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(order.as_ptr().cast()));
            Self(_mm256_permutevar8x32_epi32(self.0, order))
        }
    }

    /// Clamps indices to a table of `len` ≥ 1 entries, and below 2³¹, which gathers take as signed.
    #[inline(always)]
    fn clamped(self, len: usize) -> Self {
        let last = (len - 1).min(i32::MAX as usize) as i32;
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_min_epu32(self.0, _mm256_set1_epi32(last))) }
    }
}

/// The methods that read and write slices, which differ between numbers and words by their instructions only.
macro_rules! memory {
    ($t:ty, $load:ident, $load_where:ident, $store:ident, $store_where:ident, $gather:ident, $pointer:ty) => {
        #[inline(always)]
        fn load(from: &[$t]) -> Self {
            if from.len() >= 8 {
                // SAFETY: the slice has 8 places; needs no alignment.
                unsafe { Self($load(from.as_ptr().cast())) }
            } else {
                Self::load_where(Avx2Mask::splat(true), from)
            }
        }
        #[inline(always)]
        fn load_where(mask: Avx2Mask, from: &[$t]) -> Self {
            let inside = mask & Avx2Mask::first(from.len());
            // SAFETY: only the lanes inside the slice are read.
            unsafe { Self($load_where(from.as_ptr().cast(), _mm256_castps_si256(inside.0))) }
        }
        #[inline(always)]
        fn store(self, to: &mut [$t]) {
            if to.len() >= 8 {
                // SAFETY: the slice has 8 places; needs no alignment.
                unsafe { $store(to.as_mut_ptr().cast(), self.0) }
            } else {
                self.store_where(Avx2Mask::splat(true), to);
            }
        }
        #[inline(always)]
        fn store_where(self, mask: Avx2Mask, to: &mut [$t]) {
            let inside = mask & Avx2Mask::first(to.len());
            // SAFETY: only the lanes inside the slice are written.
            unsafe { $store_where(to.as_mut_ptr().cast(), _mm256_castps_si256(inside.0), self.0) }
        }
        #[inline(always)]
        fn gather(table: &[$t], index: Avx2Word) -> Self {
            if table.is_empty() {
                return Self::splat(<$t>::default());
            }
            // SAFETY: the indices are clamped to the table.
            unsafe { Self($gather::<4>(table.as_ptr().cast::<$pointer>(), index.clamped(table.len()).0)) }
        }
    };
}

impl Real for Avx2 {
    const LANES: usize = 8;
    type Word = Avx2Word;
    type Mask = Avx2Mask;
    type Double = Avx2Double;

    binary!(min _mm256_min_ps, max _mm256_max_ps);
    memory!(
        f32,
        _mm256_loadu_ps,
        _mm256_maskload_ps,
        _mm256_storeu_ps,
        _mm256_maskstore_ps,
        _mm256_i32gather_ps,
        f32
    );

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_set1_ps(x)) }
    }
    #[inline(always)]
    fn compress_store(self, mask: Avx2Mask, to: &mut [f32]) -> usize {
        Self::from_bits(self.to_bits().packed(mask)).store(to);
        mask.count().min(to.len())
    }
    #[inline(always)]
    fn gather_rows(table: &[[f32; 4]], index: Avx2Word) -> [Self; 4] {
        if table.is_empty() {
            return [Self::splat(0.0); 4];
        }
        let mut at = [0; 8];
        index.clamped(table.len()).store(&mut at);
        // SAFETY: the indices are clamped to the table, whose rows are 4 numbers. Otherwise see the head of the file.
        unsafe {
            let mut rows = [_mm256_setzero_ps(); 4];
            for (lane, two) in rows.iter_mut().enumerate() {
                let low = _mm_loadu_ps(table.as_ptr().add(at[lane] as usize).cast());
                let high = _mm_loadu_ps(table.as_ptr().add(at[lane + 4] as usize).cast());
                *two = _mm256_set_m128(high, low);
            }
            // A transposition of 4×4 numbers in each half.
            let (a, b) = (_mm256_unpacklo_ps(rows[0], rows[1]), _mm256_unpackhi_ps(rows[0], rows[1]));
            let (c, d) = (_mm256_unpacklo_ps(rows[2], rows[3]), _mm256_unpackhi_ps(rows[2], rows[3]));
            let (x, y) = (_mm256_shuffle_ps::<0x44>(a, c), _mm256_shuffle_ps::<0xee>(a, c));
            let (z, w) = (_mm256_shuffle_ps::<0x44>(b, d), _mm256_shuffle_ps::<0xee>(b, d));
            [Self(x), Self(y), Self(z), Self(w)]
        }
    }
    #[inline(always)]
    fn select(mask: Avx2Mask, yes: Self, no: Self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_blendv_ps(no.0, yes.0, mask.0)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::from_bits(self.to_bits() & Avx2Word::splat(0x7fff_ffff))
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self::from_bits(self.abs().to_bits() | (sign.to_bits() & Avx2Word::splat(0x8000_0000)))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_sqrt_ps(self.0)) }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_floor_ps(self.0)) }
    }
    #[inline(always)]
    fn round_ties_even(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_round_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0)) }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx2Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx2Mask(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> Avx2Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx2Mask(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx2Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx2Mask(_mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn to_bits(self) -> Avx2Word {
        // SAFETY: see the head of the file.
        unsafe { Avx2Word(_mm256_castps_si256(self.0)) }
    }
    #[inline(always)]
    fn from_bits(bits: Avx2Word) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_castsi256_ps(bits.0)) }
    }
    #[inline(always)]
    fn to_int(self) -> Avx2Word {
        // SAFETY: see the head of the file.
        unsafe { Avx2Word(_mm256_cvttps_epi32(self.0)) }
    }
}

impl Word for Avx2Word {
    type Real = Avx2;
    type Mask = Avx2Mask;

    binary!(
        wrapping_add _mm256_add_epi32,
        wrapping_sub _mm256_sub_epi32,
        wrapping_mul _mm256_mullo_epi32
    );
    memory!(
        u32,
        _mm256_loadu_si256,
        _mm256_maskload_epi32,
        _mm256_storeu_si256,
        _mm256_maskstore_epi32,
        _mm256_i32gather_epi32,
        i32
    );

    #[inline(always)]
    fn splat(x: u32) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_set1_epi32(x as i32)) }
    }
    #[inline(always)]
    fn lane_index() -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)) }
    }
    #[inline(always)]
    fn compress_store(self, mask: Avx2Mask, to: &mut [u32]) -> usize {
        self.packed(mask).store(to);
        mask.count().min(to.len())
    }
    #[inline(always)]
    fn select(mask: Avx2Mask, yes: Self, no: Self) -> Self {
        Avx2::select(mask, Avx2::from_bits(yes), Avx2::from_bits(no)).to_bits()
    }
    #[inline(always)]
    fn rotate_left(self, n: u32) -> Self {
        // A shift by 32 bits gives 0.
        (self << (n & 31)) | (self >> (32 - (n & 31)))
    }
    #[inline(always)]
    fn reverse_bits(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe {
            // Reverses the bytes of each word, and the bits of each byte by two tables of 16 entries.
            let backwards = _mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12);
            let nibbles = _mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15);
            let (backwards, nibbles) =
                (_mm256_broadcastsi128_si256(backwards), _mm256_broadcastsi128_si256(nibbles));
            let bytes = _mm256_shuffle_epi8(self.0, backwards);
            let four = _mm256_set1_epi8(15);
            let high = _mm256_and_si256(_mm256_srli_epi16::<4>(bytes), four);
            let low = _mm256_shuffle_epi8(nibbles, _mm256_and_si256(bytes, four));
            Self(_mm256_or_si256(_mm256_shuffle_epi8(nibbles, high), _mm256_slli_epi16::<4>(low)))
        }
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx2Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx2Mask(_mm256_castsi256_ps(_mm256_cmpeq_epi32(self.0, other.0))) }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx2Mask {
        let sign = Self::splat(0x8000_0000);
        (self ^ sign).lt_signed(other ^ sign)
    }
    #[inline(always)]
    fn lt_signed(self, other: Self) -> Avx2Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx2Mask(_mm256_castsi256_ps(_mm256_cmpgt_epi32(other.0, self.0))) }
    }
    #[inline(always)]
    fn int_to_real(self) -> Avx2 {
        // SAFETY: see the head of the file.
        unsafe { Avx2(_mm256_cvtepi32_ps(self.0)) }
    }
}

double!(Avx2Double, Avx2, Avx2Mask);
