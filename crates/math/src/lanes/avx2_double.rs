//! Eight numbers in f64, in two registers of AVX2.
//!
//! Safety: as for the numbers in f32, see `avx2.rs`.
#![allow(unsafe_code)]

use super::sealed::Sealed;
use std::arch::x86_64::*;
use std::ops::*;

/// Eight numbers in f64, the first four and the others.
#[derive(Clone, Copy, Debug)]
pub struct Avx2Double(__m256d, __m256d);

impl Sealed for Avx2Double {}

/// Operators of two operands, each of one instruction per half.
macro_rules! binary {
    ($($operator:ident $name:ident $instruction:ident),*) => {$(
        impl $operator for Avx2Double {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: see the head of the file.
                unsafe { Self($instruction(self.0, other.0), $instruction(self.1, other.1)) }
            }
        }
    )*};
}

binary!(Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

/// The methods of `Double`, with numbers and truth values as registers.
impl Avx2Double {
    #[inline(always)]
    pub fn splat(x: f64) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_set1_pd(x), _mm256_set1_pd(x)) }
    }
    #[inline(always)]
    pub fn from_real(x: __m256) -> Self {
        // SAFETY: see the head of the file.
        unsafe {
            Self(_mm256_cvtps_pd(_mm256_castps256_ps128(x)), _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(x)))
        }
    }
    #[inline(always)]
    pub fn to_real(self) -> __m256 {
        // SAFETY: see the head of the file.
        unsafe { _mm256_set_m128(_mm256_cvtpd_ps(self.1), _mm256_cvtpd_ps(self.0)) }
    }
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_max_pd(self.0, other.0), _mm256_max_pd(self.1, other.1)) }
    }
    #[inline(always)]
    pub fn abs(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Self(_mm256_andnot_pd(sign, self.0), _mm256_andnot_pd(sign, self.1))
        }
    }
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        // SAFETY: see the head of the file.
        unsafe { Self(_mm256_sqrt_pd(self.0), _mm256_sqrt_pd(self.1)) }
    }
    #[inline(always)]
    pub fn lt(self, other: Self) -> __m256 {
        // SAFETY: see the head of the file.
        unsafe {
            let low = _mm256_castpd_ps(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0));
            let high = _mm256_castpd_ps(_mm256_cmp_pd::<_CMP_LT_OQ>(self.1, other.1));
            // One half of each 64 bits, then the quarters in order.
            let both = _mm256_castps_pd(_mm256_shuffle_ps::<0x88>(low, high));
            _mm256_castpd_ps(_mm256_permute4x64_pd::<0xd8>(both))
        }
    }
    #[inline(always)]
    pub fn select(mask: __m256, yes: Self, no: Self) -> Self {
        // SAFETY: see the head of the file.
        unsafe {
            let mask = _mm256_castps_si256(mask);
            let low = _mm256_castsi256_pd(_mm256_cvtepi32_epi64(_mm256_castsi256_si128(mask)));
            let high = _mm256_castsi256_pd(_mm256_cvtepi32_epi64(_mm256_extracti128_si256::<1>(mask)));
            Self(_mm256_blendv_pd(no.0, yes.0, low), _mm256_blendv_pd(no.1, yes.1, high))
        }
    }
}
