//! The kernels of each machine, and which of them runs. Only here, in `memory` and in `stack` has the workspace
//! `unsafe` code.
//!
//! `Avx2` values exist only inside [`avx2`], which is entered only where the machine was found to have AVX2.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod x86;

use super::lanes::Portable;
use super::memory::Memory;
use super::node::Child;
use super::traverse::walk;
use super::{Candidate, Kernel, Tree, TriangleHit};
use dapple_math::Ray;

/// Whether this machine can run a kernel.
pub(super) fn runs(kernel: Kernel) -> bool {
    match kernel {
        #[cfg(target_arch = "x86_64")]
        Kernel::Avx2 => {
            is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("popcnt")
        }
        Kernel::Sse2 => cfg!(target_arch = "x86_64"),
        Kernel::Portable => true,
        #[cfg(not(target_arch = "x86_64"))]
        Kernel::Avx2 => false,
    }
}

/// Runs the query on the tree's kernel.
#[inline]
pub(super) fn run<C: Candidate, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    candidate: &C,
) -> Option<TriangleHit> {
    match tree.kernel {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a tree's kernel is one for which `runs` holds (`Tree::build`, `Tree::with_kernel`).
        Kernel::Avx2 => unsafe { avx2::<C, ANY>(tree, ray, candidate) },
        #[cfg(target_arch = "x86_64")]
        Kernel::Sse2 => sse2::<C, ANY>(tree, ray, candidate),
        _ => portable::<C, ANY>(tree, ray, candidate),
    }
}

/// # Safety
/// The machine must have AVX2, BMI1 and POPCNT.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,popcnt")]
unsafe fn avx2<C: Candidate, const ANY: bool>(tree: &Tree, ray: &Ray, candidate: &C) -> Option<TriangleHit> {
    walk::<x86::Avx2, C, ANY>(tree, ray, candidate)
}

#[cfg(target_arch = "x86_64")]
#[inline(never)]
fn sse2<C: Candidate, const ANY: bool>(tree: &Tree, ray: &Ray, candidate: &C) -> Option<TriangleHit> {
    walk::<x86::Sse2, C, ANY>(tree, ray, candidate)
}

#[inline(never)]
fn portable<C: Candidate, const ANY: bool>(tree: &Tree, ray: &Ray, candidate: &C) -> Option<TriangleHit> {
    walk::<Portable, C, ANY>(tree, ray, candidate)
}

/// Asks for the first four lines of a child.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn prefetch(memory: &Memory, child: Child) {
    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    for line in 0..4 {
        // SAFETY: SSE is part of every x86-64; a prefetch does not read.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(memory.near(child).wrapping_add(64 * line)) };
    }
}

/// Elsewhere there is no such request in stable Rust.
#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
pub(super) fn prefetch(_: &Memory, _: Child) {}
