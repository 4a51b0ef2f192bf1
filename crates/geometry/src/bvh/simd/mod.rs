//! Selection of the traversal kernel for the machine. This module, `memory` and `stack` contain the only `unsafe` code
//! of the crate.
//!
//! `Avx2` values exist only inside [`avx2`], which is called only on machines where AVX2 was detected.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod x86;

use super::hit_filter::{HitFilter, TriangleHit};
use super::kernel::Kernel;
use super::lanes::Portable;
use super::traverse::traverse;
use super::tree::Tree;
use dapple_math::Ray;

impl Tree {
    /// The nearest accepted triangle with 0 < t < t_max; at equal t the one with the lowest id.
    #[inline]
    pub fn intersect<C: HitFilter<TriangleHit>>(&self, ray: &Ray, filter: &C) -> Option<TriangleHit> {
        run::<C, false>(self, ray, filter)
    }

    /// Whether the filter accepts any triangle with 0 < t < t_max.
    #[inline]
    pub fn occluded<C: HitFilter<TriangleHit>>(&self, ray: &Ray, filter: &C) -> bool {
        run::<C, true>(self, ray, filter).is_some()
    }
}

/// Runs the query on the tree's kernel.
#[inline]
fn run<C: HitFilter<TriangleHit>, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    filter: &C,
) -> Option<TriangleHit> {
    match tree.kernel {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a tree's kernel is one for which `Kernel::runs` holds (`Tree::build`, `Tree::with_kernel`).
        Kernel::Avx2 => unsafe { avx2::<C, ANY>(tree, ray, filter) },
        #[cfg(target_arch = "x86_64")]
        Kernel::Sse2 => sse2::<C, ANY>(tree, ray, filter),
        _ => portable::<C, ANY>(tree, ray, filter),
    }
}

/// # Safety
/// The machine must support AVX2, BMI1 and POPCNT.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,popcnt")]
unsafe fn avx2<C: HitFilter<TriangleHit>, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    filter: &C,
) -> Option<TriangleHit> {
    traverse::<x86::Avx2, C, ANY>(tree, ray, filter)
}

#[cfg(target_arch = "x86_64")]
#[inline(never)]
fn sse2<C: HitFilter<TriangleHit>, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    filter: &C,
) -> Option<TriangleHit> {
    traverse::<x86::Sse2, C, ANY>(tree, ray, filter)
}

#[inline(never)]
fn portable<C: HitFilter<TriangleHit>, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    filter: &C,
) -> Option<TriangleHit> {
    traverse::<Portable, C, ANY>(tree, ray, filter)
}
