//! Sixteen numbers in f64, in two registers of AVX-512.
//!
//! Safety: as for the numbers in f32, see `avx512.rs`.
#![allow(unsafe_code)]

use super::sealed::Sealed;
use std::arch::x86_64::*;
use std::ops::*;

/// Sixteen numbers in f64, the first eight and the others.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Double(__m512d, __m512d);

impl Sealed for Avx512Double {}

/// Operators of two operands, each of one instruction per half.
macro_rules! binary {
    ($($operator:ident $name:ident $instruction:ident),*) => {$(
        impl $operator for Avx512Double {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: see the head of the file.
                unsafe { Self($instruction(self.0, other.0), $instruction(self.1, other.1)) }
            }
        }
    )*};
}

binary!(Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

/// The methods of `Double`, with numbers and truth values as registers.
impl Avx512Double {
    #[inline(always)]
    pub fn splat(x: f64) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_set1_pd(x), _mm512_set1_pd(x)) }
    }
    #[inline(always)]
    pub fn from_real(x: __m512) -> Self {
        // SAFETY: see the head of the file.
        unsafe {
            Self(_mm512_cvtps_pd(_mm512_castps512_ps256(x)), _mm512_cvtps_pd(_mm512_extractf32x8_ps::<1>(x)))
        }
    }
    #[inline(always)]
    pub fn to_real(self) -> __m512 {
        // SAFETY: see the head of the file.
        unsafe {
            let low = _mm512_castps256_ps512(_mm512_cvtpd_ps(self.0));
            _mm512_insertf32x8::<1>(low, _mm512_cvtpd_ps(self.1))
        }
    }
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_max_pd(self.0, other.0), _mm512_max_pd(self.1, other.1)) }
    }
    #[inline(always)]
    pub fn abs(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_abs_pd(self.0), _mm512_abs_pd(self.1)) }
    }
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm512_sqrt_pd(self.0), _mm512_sqrt_pd(self.1)) }
    }
    #[inline(always)]
    pub fn lt(self, other: Self) -> __mmask16 {
        // SAFETY: see the head of the file.
        unsafe {
            let low = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0);
            let high = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.1, other.1);
            u16::from(low) | u16::from(high) << 8
        }
    }
    #[inline(always)]
    pub fn select(mask: __mmask16, yes: Self, no: Self) -> Self {
        // SAFETY: see the head of the file.
        unsafe {
            let (low, high) = (mask as u8, (mask >> 8) as u8);
            Self(_mm512_mask_blend_pd(low, no.0, yes.0), _mm512_mask_blend_pd(high, no.1, yes.1))
        }
    }
}
