//! Eight lanes in x86-64 registers.

use crate::bvh::lanes::{Floats, Lanes, bits, lowest, nearest};
use crate::bvh::node::{Child, Children};
use crate::bvh::stack::Stack;
use std::arch::x86_64::*;

/// Two SSE registers.
#[derive(Clone, Copy)]
pub struct Sse2(__m128, __m128);

macro_rules! sse {
    ($($name:ident $op:ident),*) => {$(
        #[inline(always)]
        fn $name(self, o: Self) -> Self {
            // SAFETY: SSE2 is part of every x86-64.
            unsafe { Self($op(self.0, o.0), $op(self.1, o.1)) }
        }
    )*};
}

macro_rules! sse_mask {
    ($($name:ident $op:ident),*) => {$(
        #[inline(always)]
        fn $name(self, o: Self) -> u32 {
            // SAFETY: SSE2 is part of every x86-64.
            unsafe {
                (_mm_movemask_ps($op(self.0, o.0)) | (_mm_movemask_ps($op(self.1, o.1)) << 4)) as u32
            }
        }
    )*};
}

impl Floats for Sse2 {
    bits!();
    sse!(add _mm_add_ps, sub _mm_sub_ps, mul _mm_mul_ps, div _mm_div_ps, min _mm_min_ps, max _mm_max_ps);
    sse_mask!(lt _mm_cmplt_ps, le _mm_cmple_ps, eq _mm_cmpeq_ps);
    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: SSE2 is part of every x86-64.
        unsafe { Self(_mm_set1_ps(x), _mm_set1_ps(x)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: SSE2 is part of every x86-64.
        unsafe {
            let sign = _mm_set1_ps(-0.0);
            Self(_mm_andnot_ps(sign, self.0), _mm_andnot_ps(sign, self.1))
        }
    }
}

impl Lanes for Sse2 {
    #[inline(always)]
    fn load(x: &[f32; 8]) -> Self {
        // SAFETY: reads the 2×4 floats of the array; needs no alignment.
        unsafe { Self(_mm_loadu_ps(x.as_ptr()), _mm_loadu_ps(x.as_ptr().add(4))) }
    }
    #[inline(always)]
    fn store(self, to: &mut [f32; 8]) {
        // SAFETY: writes the 2×4 floats of the array; needs no alignment.
        unsafe {
            _mm_storeu_ps(to.as_mut_ptr(), self.0);
            _mm_storeu_ps(to.as_mut_ptr().add(4), self.1);
        }
    }
    #[inline(always)]
    fn nearest(self, far: Self, child: &Children, stack: &mut Stack, _: impl Fn(Child)) -> Option<Child> {
        nearest(&self.array(), self.lt(far), child, stack)
    }
}

/// One AVX register.
#[derive(Clone, Copy)]
pub struct Avx2(__m256);

macro_rules! avx {
    ($($name:ident $op:ident),*) => {$(
        #[inline(always)]
        fn $name(self, o: Self) -> Self {
            // SAFETY: `Avx2` values exist only where AVX2 is available.
            unsafe { Self($op(self.0, o.0)) }
        }
    )*};
}

macro_rules! avx_mask {
    ($($name:ident $op:ident),*) => {$(
        #[inline(always)]
        fn $name(self, o: Self) -> u32 {
            // SAFETY: `Avx2` values exist only where AVX2 is available.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<$op>(self.0, o.0)) as u32 }
        }
    )*};
}

/// One layer of a sorting network: the lanes of `$upper` keep the minimum of themselves and `$partner`, the other lanes
/// the maximum.
macro_rules! layer {
    ($v:ident, $partner:expr, $upper:literal) => {
        let partner = $partner;
        let $v = _mm256_blend_epi32::<$upper>(_mm256_max_epi32($v, partner), _mm256_min_epi32($v, partner));
    };
}

impl Floats for Avx2 {
    bits!();
    avx!(add _mm256_add_ps, sub _mm256_sub_ps, mul _mm256_mul_ps, div _mm256_div_ps);
    avx!(min _mm256_min_ps, max _mm256_max_ps);
    avx_mask!(lt _CMP_LT_OQ, le _CMP_LE_OQ, eq _CMP_EQ_OQ);
    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: called only from `traverse` inside `avx2`, as are all functions that create an `Avx2`.
        unsafe { Self(_mm256_set1_ps(x)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: `Avx2` values exist only where AVX2 is available.
        unsafe { Self(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)) }
    }
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn load(x: &[f32; 8]) -> Self {
        // SAFETY: as in `splat`; reads the 8 floats of the array; needs no alignment.
        unsafe { Self(_mm256_loadu_ps(x.as_ptr())) }
    }
    #[inline(always)]
    fn store(self, to: &mut [f32; 8]) {
        // SAFETY: writes the 8 floats of the array; needs no alignment.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn later(self, o: Self) -> Self {
        // SAFETY: `Avx2` values exist only where AVX2 is available. Non-negative floats have the same order as their
        // bits.
        unsafe {
            let (a, b) = (_mm256_castps_si256(self.0), _mm256_castps_si256(o.0));
            Self(_mm256_castsi256_ps(_mm256_max_epi32(a, b)))
        }
    }
    #[inline(always)]
    fn earlier(self, o: Self) -> Self {
        // SAFETY: as in `later`.
        unsafe {
            let (a, b) = (_mm256_castps_si256(self.0), _mm256_castps_si256(o.0));
            Self(_mm256_castsi256_ps(_mm256_min_epi32(a, b)))
        }
    }
    /// The nearest child is found by three minima, so that descending does not wait for the order of the others. They
    /// are sorted by a bitonic network over all eight keys, in which lanes that are not entered have the key −1 and are
    /// last.
    ///
    /// Distances are compared as integers, which gives the same order for non-negative floats and puts all others
    /// below.
    #[inline(always)]
    fn nearest(self, far: Self, child: &Children, stack: &mut Stack, ahead: impl Fn(Child)) -> Option<Child> {
        let (entered, mask) = self.entered(far);
        if at_most_one(mask) {
            return lowest(mask, child);
        }
        // SAFETY: `Avx2` values exist only where AVX2 is available; `top` has room for eight values at both places.
        unsafe {
            let lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let bits = _mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(self.0));
            let missed = _mm256_xor_si256(entered, _mm256_set1_epi32(-1));
            let v = _mm256_or_si256(_mm256_or_si256(bits, lane), missed);
            let m = _mm256_min_epu32(v, _mm256_permute4x64_epi64::<0b01_00_11_10>(v));
            let m = _mm256_min_epu32(m, _mm256_shuffle_epi32::<0b01_00_11_10>(m));
            let m = _mm256_min_epu32(m, _mm256_shuffle_epi32::<0b10_11_00_01>(m));
            let children = _mm256_loadu_si256(child.as_ptr().cast());
            // The lowest three bits of a key are its lane; the permutation uses only these bits.
            let mut first = _mm256_cvtsi256_si32(_mm256_permutevar8x32_epi32(children, m)) as u32;
            // An empty instruction that keeps the compiler from moving the sorting network, which is not on the
            // critical path, before the selection of the nearest child.
            std::arch::asm!("/* {0:e} */", inout(reg) first, options(nomem, nostack, preserves_flags));
            let (near_top, child_top) = stack.top();
            layer!(v, _mm256_shuffle_epi32::<0b10_11_00_01>(v), 0b1010_1010);
            layer!(v, _mm256_shuffle_epi32::<0b00_01_10_11>(v), 0b1100_1100);
            layer!(v, _mm256_shuffle_epi32::<0b10_11_00_01>(v), 0b1010_1010);
            let reversed = _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0);
            layer!(v, _mm256_permutevar8x32_epi32(v, reversed), 0b1111_0000);
            layer!(v, _mm256_shuffle_epi32::<0b01_00_11_10>(v), 0b1100_1100);
            layer!(v, _mm256_shuffle_epi32::<0b10_11_00_01>(v), 0b1010_1010);
            _mm256_storeu_si256(near_top.cast(), v);
            _mm256_storeu_si256(child_top.cast(), _mm256_permutevar8x32_epi32(children, v));
            // Of the eight entries written, all that were entered except the nearest are now part of the stack.
            stack.grow(mask.count_ones() as usize - 1);
            ahead(stack.last());
            Some(Child::from_bits(first))
        }
    }
    #[inline(always)]
    fn first(self, far: Self, child: &Children, stack: &mut Stack, ahead: impl Fn(Child)) -> Option<Child> {
        let (_, mask) = self.entered(far);
        if at_most_one(mask) {
            return lowest(mask, child);
        }
        let (_, child_top) = stack.top();
        // SAFETY: `Avx2` values exist only where AVX2 is available; `top` has room for eight values.
        unsafe {
            let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(COMPACT[mask as usize & 255].as_ptr().cast()));
            let children = _mm256_loadu_si256(child.as_ptr().cast());
            _mm256_storeu_si256(child_top.cast(), _mm256_permutevar8x32_epi32(children, order));
            stack.grow(mask.count_ones() as usize - 1);
        }
        ahead(stack.last());
        lowest(mask, child)
    }
}

impl Avx2 {
    /// All bits set in the lanes where self < `far`, and the mask of these lanes.
    #[inline(always)]
    fn entered(self, far: Self) -> (__m256i, u32) {
        // SAFETY: `Avx2` values exist only where AVX2 is available.
        unsafe {
            let entered = _mm256_cmpgt_epi32(_mm256_castps_si256(far.0), _mm256_castps_si256(self.0));
            (entered, _mm256_movemask_ps(_mm256_castsi256_ps(entered)) as u32)
        }
    }
}

/// Whether at most one of the eight bits of a mask is set. The subtraction of 1 is done modulo 256, which gives the
/// same result: for a plain subtraction the compiler emits a bit count, which delays the branch by two cycles.
#[inline(always)]
fn at_most_one(mask: u32) -> bool {
    (mask + 255) & mask == 0
}

/// Per mask: the indices of its set lanes, the lowest last.
static COMPACT: [[u8; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut at) = (8u8, 0);
        while lane > 0 {
            lane -= 1;
            if mask >> lane & 1 == 1 {
                table[mask][at] = lane;
                at += 1;
            }
        }
        mask += 1;
    }
    table
};
