//! Sixteen lanes in the registers of AVX-512.
//!
//! All methods are `inline(always)` and become their instructions inside a function that is compiled for AVX-512.
//!
//! Safety: code outside of `lanes` cannot name the types, and `dispatch` alone chooses them, where the machine has
//! AVX-512 (F, BW, DQ, VL and CD) and what eight lanes need. Instructions of these sets can therefore be executed
//! wherever a method is called. Further conditions, on pointers, are stated beside the code.
#![allow(unsafe_code)]

use super::avx512_double::Avx512Double;
use super::double::double;
use super::mask::Mask;
use super::real::{Double, Real, Word};
use super::sealed::Sealed;
use std::arch::x86_64::*;
use std::ops::*;

/// Sixteen numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Avx512(__m512);

/// Sixteen words.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Avx512Word(__m512i);

/// Sixteen truth values, one bit each.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Avx512Mask(__mmask16);

impl Sealed for Avx512 {}
impl Sealed for Avx512Word {}
impl Sealed for Avx512Mask {}

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

binary!(Avx512: Add add _mm512_add_ps, Sub sub _mm512_sub_ps, Mul mul _mm512_mul_ps, Div div _mm512_div_ps);
binary!(Avx512Word: BitAnd bitand _mm512_and_si512, BitOr bitor _mm512_or_si512, BitXor bitxor _mm512_xor_si512);

macro_rules! mask {
    ($($operator:ident $name:ident $with:tt),*) => {$(
        impl $operator for Avx512Mask {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0 $with other.0)
            }
        }
    )*};
}
mask!(BitAnd bitand &, BitOr bitor |, BitXor bitxor ^);

macro_rules! assign {
    ($($operator:ident $name:ident $with:tt),*) => {$(
        impl $operator for Avx512 {
            #[inline(always)]
            fn $name(&mut self, other: Self) {
                *self = *self $with other;
            }
        }
    )*};
}
assign!(AddAssign add_assign +, SubAssign sub_assign -, MulAssign mul_assign *);

impl Neg for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::from_bits(self.to_bits() ^ Avx512Word::splat(0x8000_0000))
    }
}

impl Not for Avx512Word {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        self ^ Self::splat(u32::MAX)
    }
}

impl Not for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Shl<u32> for Avx512Word {
    type Output = Self;
    #[inline(always)]
    fn shl(self, n: u32) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_sll_epi32(self.0, _mm_cvtsi32_si128(n as i32))) }
    }
}

impl Shr<u32> for Avx512Word {
    type Output = Self;
    #[inline(always)]
    fn shr(self, n: u32) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_srl_epi32(self.0, _mm_cvtsi32_si128(n as i32))) }
    }
}

impl Mask for Avx512Mask {
    const LANES: usize = 16;
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self(if value { 0xffff } else { 0 })
    }
    #[inline(always)]
    fn from_bitmask(bits: u32) -> Self {
        Self(bits as __mmask16)
    }
    #[inline(always)]
    fn bitmask(self) -> u32 {
        u32::from(self.0)
    }
}

impl Avx512Word {
    /// Moves the lanes of `mask` to the front.
    #[inline(always)]
    fn packed(self, mask: Avx512Mask) -> Self {
        // Compressed in the register: the form that writes to memory is slow on some machines.
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_maskz_compress_epi32(mask.0, self.0)) }
    }

    /// Clamps indices to a table of `len` ≥ 1 entries, and below 2³¹, which gathers take as signed.
    #[inline(always)]
    fn clamped(self, len: usize) -> Self {
        let last = (len - 1).min(i32::MAX as usize) as i32;
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_min_epu32(self.0, _mm512_set1_epi32(last))) }
    }
}

/// The methods that read and write slices, which differ between numbers and words by their instructions only.
macro_rules! memory {
    ($t:ty, $load:ident, $load_where:ident, $store:ident, $store_where:ident, $gather:ident, $pointer:ty) => {
        #[inline(always)]
        fn load(from: &[$t]) -> Self {
            if from.len() >= 16 {
                // SAFETY: the slice has 16 places; needs no alignment.
                unsafe { Self($load(from.as_ptr().cast())) }
            } else {
                Self::load_where(Avx512Mask::splat(true), from)
            }
        }
        #[inline(always)]
        fn load_where(mask: Avx512Mask, from: &[$t]) -> Self {
            let inside = mask & Avx512Mask::first(from.len());
            // SAFETY: only the lanes inside the slice are read.
            unsafe { Self($load_where(inside.0, from.as_ptr().cast())) }
        }
        #[inline(always)]
        fn store(self, to: &mut [$t]) {
            if to.len() >= 16 {
                // SAFETY: the slice has 16 places; needs no alignment.
                unsafe { $store(to.as_mut_ptr().cast(), self.0) }
            } else {
                self.store_where(Avx512Mask::splat(true), to);
            }
        }
        #[inline(always)]
        fn store_where(self, mask: Avx512Mask, to: &mut [$t]) {
            let inside = mask & Avx512Mask::first(to.len());
            // SAFETY: only the lanes inside the slice are written.
            unsafe { $store_where(to.as_mut_ptr().cast(), inside.0, self.0) }
        }
        #[inline(always)]
        fn gather(table: &[$t], index: Avx512Word) -> Self {
            if table.is_empty() {
                return Self::splat(<$t>::default());
            }
            // SAFETY: the indices are clamped to the table.
            unsafe { Self($gather::<4>(index.clamped(table.len()).0, table.as_ptr().cast::<$pointer>())) }
        }
    };
}

impl Real for Avx512 {
    const LANES: usize = 16;
    type Word = Avx512Word;
    type Mask = Avx512Mask;
    type Double = Avx512Double;

    binary!(min _mm512_min_ps, max _mm512_max_ps);
    memory!(
        f32,
        _mm512_loadu_ps,
        _mm512_maskz_loadu_ps,
        _mm512_storeu_ps,
        _mm512_mask_storeu_ps,
        _mm512_i32gather_ps,
        f32
    );

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_set1_ps(x)) }
    }
    #[inline(always)]
    fn compress_store(self, mask: Avx512Mask, to: &mut [f32]) -> usize {
        Self::from_bits(self.to_bits().packed(mask)).store(to);
        mask.count().min(to.len())
    }
    #[inline(always)]
    fn gather_rows(table: &[[f32; 4]], index: Avx512Word) -> [Self; 4] {
        if table.is_empty() {
            return [Self::splat(0.0); 4];
        }
        let mut at = [0; 16];
        index.clamped(table.len()).store(&mut at);
        // SAFETY: the indices are clamped to the table, whose rows are 4 numbers. Otherwise see the head of the file.
        unsafe {
            let mut rows = [_mm512_setzero_ps(); 4];
            for (lane, four) in rows.iter_mut().enumerate() {
                let row = table.as_ptr().cast::<f32>();
                let x = _mm512_castps128_ps512(_mm_loadu_ps(row.add(4 * at[lane] as usize)));
                let x = _mm512_insertf32x4::<1>(x, _mm_loadu_ps(row.add(4 * at[lane + 4] as usize)));
                let x = _mm512_insertf32x4::<2>(x, _mm_loadu_ps(row.add(4 * at[lane + 8] as usize)));
                *four = _mm512_insertf32x4::<3>(x, _mm_loadu_ps(row.add(4 * at[lane + 12] as usize)));
            }
            // A transposition of 4×4 numbers in each quarter.
            let (a, b) = (_mm512_unpacklo_ps(rows[0], rows[1]), _mm512_unpackhi_ps(rows[0], rows[1]));
            let (c, d) = (_mm512_unpacklo_ps(rows[2], rows[3]), _mm512_unpackhi_ps(rows[2], rows[3]));
            let (x, y) = (_mm512_shuffle_ps::<0x44>(a, c), _mm512_shuffle_ps::<0xee>(a, c));
            let (z, w) = (_mm512_shuffle_ps::<0x44>(b, d), _mm512_shuffle_ps::<0xee>(b, d));
            [Self(x), Self(y), Self(z), Self(w)]
        }
    }
    #[inline(always)]
    fn select(mask: Avx512Mask, yes: Self, no: Self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_mask_blend_ps(mask.0, no.0, yes.0)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::from_bits(self.to_bits() & Avx512Word::splat(0x7fff_ffff))
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self::from_bits(self.abs().to_bits() | (sign.to_bits() & Avx512Word::splat(0x8000_0000)))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_sqrt_ps(self.0)) }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0)) }
    }
    #[inline(always)]
    fn round_ties_even(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_roundscale_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0)) }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx512Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx512Mask(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> Avx512Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx512Mask(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx512Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx512Mask(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn to_bits(self) -> Avx512Word {
        // SAFETY: see the head of the file.
        unsafe { Avx512Word(_mm512_castps_si512(self.0)) }
    }
    #[inline(always)]
    fn from_bits(bits: Avx512Word) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_castsi512_ps(bits.0)) }
    }
    #[inline(always)]
    fn to_int(self) -> Avx512Word {
        // SAFETY: see the head of the file.
        unsafe { Avx512Word(_mm512_cvttps_epi32(self.0)) }
    }
}

impl Word for Avx512Word {
    type Real = Avx512;
    type Mask = Avx512Mask;

    binary!(
        wrapping_add _mm512_add_epi32,
        wrapping_sub _mm512_sub_epi32,
        wrapping_mul _mm512_mullo_epi32
    );
    memory!(
        u32,
        _mm512_loadu_si512,
        _mm512_maskz_loadu_epi32,
        _mm512_storeu_si512,
        _mm512_mask_storeu_epi32,
        _mm512_i32gather_epi32,
        i32
    );

    #[inline(always)]
    fn splat(x: u32) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_set1_epi32(x as i32)) }
    }
    #[inline(always)]
    fn lane_index() -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)) }
    }
    #[inline(always)]
    fn compress_store(self, mask: Avx512Mask, to: &mut [u32]) -> usize {
        self.packed(mask).store(to);
        mask.count().min(to.len())
    }
    #[inline(always)]
    fn select(mask: Avx512Mask, yes: Self, no: Self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_mask_blend_epi32(mask.0, no.0, yes.0)) }
    }
    #[inline(always)]
    fn rotate_left(self, n: u32) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_rolv_epi32(self.0, _mm512_set1_epi32(n as i32))) }
    }
    #[inline(always)]
    fn reverse_bits(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe {
            // Reverses the bytes of each word, and the bits of each byte by two tables of 16 entries.
            let backwards = _mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12);
            let nibbles = _mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15);
            let (backwards, nibbles) = (_mm512_broadcast_i32x4(backwards), _mm512_broadcast_i32x4(nibbles));
            let bytes = _mm512_shuffle_epi8(self.0, backwards);
            let four = _mm512_set1_epi8(15);
            let high = _mm512_and_si512(_mm512_srli_epi16::<4>(bytes), four);
            let low = _mm512_shuffle_epi8(nibbles, _mm512_and_si512(bytes, four));
            Self(_mm512_or_si512(_mm512_shuffle_epi8(nibbles, high), _mm512_slli_epi16::<4>(low)))
        }
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx512Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx512Mask(_mm512_cmpeq_epi32_mask(self.0, other.0)) }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx512Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx512Mask(_mm512_cmplt_epu32_mask(self.0, other.0)) }
    }
    #[inline(always)]
    fn lt_signed(self, other: Self) -> Avx512Mask {
        // SAFETY: see the head of the file.
        unsafe { Avx512Mask(_mm512_cmplt_epi32_mask(self.0, other.0)) }
    }
    #[inline(always)]
    fn int_to_real(self) -> Avx512 {
        // SAFETY: see the head of the file.
        unsafe { Avx512(_mm512_cvtepi32_ps(self.0)) }
    }
}

double!(Avx512Double, Avx512, Avx512Mask);
