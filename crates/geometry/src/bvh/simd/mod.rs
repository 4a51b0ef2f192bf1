//! Selection of the traversal kernel for the machine. This module, `memory` and `stack` contain the only `unsafe` code
//! of the crate.
//!
//! `Avx2` values exist only inside [`avx2`], which is called only on machines where AVX2 was detected.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod x86;

use super::hit_filter::{HitFilter, Opaque, TriangleHit};
use super::kernel::Kernel;
use super::lanes::{Lanes, Portable};
use super::packets::Packets;
use super::traverse::traverse;
use super::tree::Tree;
use crate::Rays;
use dapple_math::Ray;
use dapple_math::lanes::dispatch;

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

impl Tree {
    /// Calls `found` with the index of each ray and the nearest triangle, as [`Tree::intersect`] finds it, in any order.
    #[inline]
    pub fn intersect_each(&self, rays: &Rays, found: impl FnMut(usize, Option<TriangleHit>)) {
        run_each::<false>(self, rays, found);
    }

    /// Calls `found` with the index of each ray and whether it is occluded, as [`Tree::occluded`] finds it, in any
    /// order.
    #[inline]
    pub fn occluded_each(&self, rays: &Rays, mut found: impl FnMut(usize, bool)) {
        run_each::<true>(self, rays, |i, hit| found(i, hit.is_some()));
    }
}

/// Runs many queries for opaque triangles: in packets where the tree is small, else in a single call of the kernel.
#[inline]
fn run_each<const ANY: bool>(tree: &Tree, rays: &Rays, found: impl FnMut(usize, Option<TriangleHit>)) {
    let single = |ray: &Ray| run::<Opaque, ANY>(tree, ray, &Opaque);
    if let Some(isa) = tree.kernel.packets(tree.triangles)
        && rays.len() >= isa.lanes()
    {
        return dispatch(isa, Packets::<_, _, ANY> { tree, rays, single, found });
    }
    match tree.kernel {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as in `run`.
        Kernel::Avx512 | Kernel::Avx2 => unsafe { avx2_each::<ANY>(tree, rays, found) },
        #[cfg(target_arch = "x86_64")]
        Kernel::Sse2 => each::<x86::Sse2, ANY>(tree, rays, found),
        _ => each::<Portable, ANY>(tree, rays, found),
    }
}

/// Traces rays one by one. The traversal is compiled into the loop: rays that are passed in memory would be loaded before
/// their numbers are stored.
#[inline(always)]
fn each<L: Lanes, const ANY: bool>(
    tree: &Tree,
    rays: &Rays,
    mut found: impl FnMut(usize, Option<TriangleHit>),
) {
    for i in 0..rays.len() {
        found(i, traverse::<L, Opaque, ANY>(tree, &rays.ray(i), &Opaque));
    }
}

/// # Safety
/// As for [`avx2`].
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,popcnt")]
unsafe fn avx2_each<const ANY: bool>(
    tree: &Tree,
    rays: &Rays,
    found: impl FnMut(usize, Option<TriangleHit>),
) {
    each::<x86::Avx2, ANY>(tree, rays, found);
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
        Kernel::Avx512 | Kernel::Avx2 => unsafe { avx2::<C, ANY>(tree, ray, filter) },
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
