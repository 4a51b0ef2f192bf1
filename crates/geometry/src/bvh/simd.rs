//! Eight floats at a time, three ways with the same bits: AVX, SSE2, arrays.
//!
//! This is the only module of the workspace with `unsafe` code. Operations are single IEEE operations in every
//! version (no fused multiply-add), `min` and `max` return the second operand when either is NaN (as the instructions
//! do), and comparisons return one bit per lane.
#![allow(unsafe_code)]

/// Eight lanes. Implementors must agree bit for bit.
pub(super) trait Lanes: Copy {
    fn splat(x: f32) -> Self;
    fn load(x: &[f32; 8]) -> Self;
    fn store(self, to: &mut [f32; 8]);
    fn add(self, o: Self) -> Self;
    fn sub(self, o: Self) -> Self;
    fn mul(self, o: Self) -> Self;
    fn div(self, o: Self) -> Self;
    /// self < o ? self : o
    fn min(self, o: Self) -> Self;
    /// self > o ? self : o
    fn max(self, o: Self) -> Self;
    fn lt(self, o: Self) -> u32;
    fn le(self, o: Self) -> u32;
    fn eq(self, o: Self) -> u32;
}

/// Plain arrays.
#[derive(Clone, Copy)]
pub(super) struct Portable([f32; 8]);

impl Portable {
    #[inline(always)]
    fn zip(self, o: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], o.0[i])))
    }
    #[inline(always)]
    fn mask(self, o: Self, f: impl Fn(f32, f32) -> bool) -> u32 {
        (0..8).fold(0, |m, i| m | (u32::from(f(self.0[i], o.0[i])) << i))
    }
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
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.zip(o, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.zip(o, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.zip(o, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        self.zip(o, |a, b| a / b)
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        self.zip(o, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        self.zip(o, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn lt(self, o: Self) -> u32 {
        self.mask(o, |a, b| a < b)
    }
    #[inline(always)]
    fn le(self, o: Self) -> u32 {
        self.mask(o, |a, b| a <= b)
    }
    #[inline(always)]
    fn eq(self, o: Self) -> u32 {
        self.mask(o, |a, b| a == b)
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) mod x86 {
    use super::Lanes;
    use std::arch::x86_64::*;

    /// Two SSE registers; SSE2 is part of every x86-64, so nothing here can be unsupported.
    #[derive(Clone, Copy)]
    pub(in super::super) struct Sse2(__m128, __m128);

    macro_rules! sse {
        ($op:ident, $a:expr, $b:expr) => {
            // SAFETY: SSE is part of the x86-64 baseline.
            unsafe { Sse2($op($a.0, $b.0), $op($a.1, $b.1)) }
        };
    }
    macro_rules! sse_mask {
        ($op:ident, $a:expr, $b:expr) => {
            // SAFETY: SSE is part of the x86-64 baseline.
            unsafe { (_mm_movemask_ps($op($a.0, $b.0)) | (_mm_movemask_ps($op($a.1, $b.1)) << 4)) as u32 }
        };
    }

    impl Lanes for Sse2 {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            // SAFETY: SSE is part of the x86-64 baseline.
            unsafe { Self(_mm_set1_ps(x), _mm_set1_ps(x)) }
        }
        #[inline(always)]
        fn load(x: &[f32; 8]) -> Self {
            // SAFETY: reads 2×4 floats inside the array; loadu needs no alignment.
            unsafe { Self(_mm_loadu_ps(x.as_ptr()), _mm_loadu_ps(x.as_ptr().add(4))) }
        }
        #[inline(always)]
        fn store(self, to: &mut [f32; 8]) {
            // SAFETY: writes 2×4 floats inside the array; storeu needs no alignment.
            unsafe {
                _mm_storeu_ps(to.as_mut_ptr(), self.0);
                _mm_storeu_ps(to.as_mut_ptr().add(4), self.1);
            }
        }
        #[inline(always)]
        fn add(self, o: Self) -> Self {
            sse!(_mm_add_ps, self, o)
        }
        #[inline(always)]
        fn sub(self, o: Self) -> Self {
            sse!(_mm_sub_ps, self, o)
        }
        #[inline(always)]
        fn mul(self, o: Self) -> Self {
            sse!(_mm_mul_ps, self, o)
        }
        #[inline(always)]
        fn div(self, o: Self) -> Self {
            sse!(_mm_div_ps, self, o)
        }
        #[inline(always)]
        fn min(self, o: Self) -> Self {
            sse!(_mm_min_ps, self, o)
        }
        #[inline(always)]
        fn max(self, o: Self) -> Self {
            sse!(_mm_max_ps, self, o)
        }
        #[inline(always)]
        fn lt(self, o: Self) -> u32 {
            sse_mask!(_mm_cmplt_ps, self, o)
        }
        #[inline(always)]
        fn le(self, o: Self) -> u32 {
            sse_mask!(_mm_cmple_ps, self, o)
        }
        #[inline(always)]
        fn eq(self, o: Self) -> u32 {
            sse_mask!(_mm_cmpeq_ps, self, o)
        }
    }

    /// One AVX register. Only made inside functions compiled for AVX2 and entered after detection.
    #[derive(Clone, Copy)]
    pub(in super::super) struct Avx2(__m256);

    macro_rules! avx {
        ($op:ident, $a:expr, $b:expr) => {
            // SAFETY: `Avx2` values exist only where AVX2 was detected (see `traverse::dispatch`).
            unsafe { Avx2($op($a.0, $b.0)) }
        };
    }
    macro_rules! avx_mask {
        ($op:expr, $a:expr, $b:expr) => {
            // SAFETY: as above.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<$op>($a.0, $b.0)) as u32 }
        };
    }

    impl Lanes for Avx2 {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            // SAFETY: called only inside functions compiled for AVX2 and entered after detection.
            unsafe { Self(_mm256_set1_ps(x)) }
        }
        #[inline(always)]
        fn load(x: &[f32; 8]) -> Self {
            // SAFETY: as `splat`; reads the 8 floats of the array, no alignment needed.
            unsafe { Self(_mm256_loadu_ps(x.as_ptr())) }
        }
        #[inline(always)]
        fn store(self, to: &mut [f32; 8]) {
            // SAFETY: as `load`, writing.
            unsafe { _mm256_storeu_ps(to.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn add(self, o: Self) -> Self {
            avx!(_mm256_add_ps, self, o)
        }
        #[inline(always)]
        fn sub(self, o: Self) -> Self {
            avx!(_mm256_sub_ps, self, o)
        }
        #[inline(always)]
        fn mul(self, o: Self) -> Self {
            avx!(_mm256_mul_ps, self, o)
        }
        #[inline(always)]
        fn div(self, o: Self) -> Self {
            avx!(_mm256_div_ps, self, o)
        }
        #[inline(always)]
        fn min(self, o: Self) -> Self {
            avx!(_mm256_min_ps, self, o)
        }
        #[inline(always)]
        fn max(self, o: Self) -> Self {
            avx!(_mm256_max_ps, self, o)
        }
        #[inline(always)]
        fn lt(self, o: Self) -> u32 {
            avx_mask!(_CMP_LT_OQ, self, o)
        }
        #[inline(always)]
        fn le(self, o: Self) -> u32 {
            avx_mask!(_CMP_LE_OQ, self, o)
        }
        #[inline(always)]
        fn eq(self, o: Self) -> u32 {
            avx_mask!(_CMP_EQ_OQ, self, o)
        }
    }
}
