//! Walking the tree: nearest first, with the entry distance on the stack; any hit ends a shadow ray.
//!
//! The slab test is conservative without an epsilon [Ize 2013]: (plane − o)·(1/d), exit widened by 4 ulp, NaN (a ray in
//! a box face) dropped by the order of min and max. Culling keeps boxes entered exactly at the best distance, for a
//! triangle of lower id may lie there.
#![allow(unsafe_code)]

use super::node::{EMPTY, LEAF, Node};
use super::simd::{Lanes, Portable};
use super::triangle::{Sheared, intersect};
use super::{Candidate, Kernel, Tree, TriangleHit};
use crate::Ray;
use glam::Vec3;
use std::mem::MaybeUninit;

/// Exit distances are widened by 4 ulp: (1 + 2γ3) of [Ize 2013], rounded up.
const WIDEN: f32 = 1.000_000_5;
/// Stack entries kept off the heap.
const SMALL: usize = 160;

/// Runs the query on the tree's kernel.
#[inline]
pub(super) fn dispatch<C: Candidate, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    candidate: &C,
) -> Option<TriangleHit> {
    if tree.root == EMPTY {
        return None;
    }
    match tree.kernel {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `Tree::with_kernel` and `Tree::build` set Avx2 only where it was detected.
        Kernel::Avx2 => unsafe { avx2::<C, ANY>(tree, ray, candidate) },
        #[cfg(target_arch = "x86_64")]
        Kernel::Sse2 => sse2::<C, ANY>(tree, ray, candidate),
        _ => portable::<C, ANY>(tree, ray, candidate),
    }
}

/// # Safety
/// The machine must have AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn avx2<C: Candidate, const ANY: bool>(tree: &Tree, ray: &Ray, candidate: &C) -> Option<TriangleHit> {
    with_stack::<super::simd::x86::Avx2, C, ANY>(tree, ray, candidate)
}

#[cfg(target_arch = "x86_64")]
#[inline(never)]
fn sse2<C: Candidate, const ANY: bool>(tree: &Tree, ray: &Ray, candidate: &C) -> Option<TriangleHit> {
    with_stack::<super::simd::x86::Sse2, C, ANY>(tree, ray, candidate)
}

#[inline(never)]
fn portable<C: Candidate, const ANY: bool>(tree: &Tree, ray: &Ray, candidate: &C) -> Option<TriangleHit> {
    with_stack::<Portable, C, ANY>(tree, ray, candidate)
}

#[inline(always)]
fn with_stack<L: Lanes, C: Candidate, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    candidate: &C,
) -> Option<TriangleHit> {
    let (ray, scale) = near_unit(ray)?;
    let hit = if tree.stack <= SMALL {
        walk::<L, C, ANY>(tree, &ray, scale, candidate, &mut [MaybeUninit::uninit(); SMALL])
    } else {
        walk::<L, C, ANY>(tree, &ray, scale, candidate, &mut vec![MaybeUninit::uninit(); tree.stack])
    };
    hit.map(|hit| TriangleHit { t: hit.t * scale, ..hit })
}

/// The ray with a direction near unit length, by a power of two, and the factor from its t to the caller's. None for
/// directions that are zero or not finite.
#[inline(always)]
fn near_unit(ray: &Ray) -> Option<(Ray, f32)> {
    let largest = ray.d.abs().max_element();
    if (1e-6..1e6).contains(&largest) {
        return Some((*ray, 1.0));
    }
    rescaled(ray, largest)
}

#[cold]
fn rescaled(ray: &Ray, largest: f32) -> Option<(Ray, f32)> {
    if !(largest > 0.0 && ray.d.is_finite()) {
        return None;
    }
    // Subnormals first become normal, exactly.
    let (d, extra) = if largest < 1e-30 { (ray.d * 1.329_228e36, 120) } else { (ray.d, 0) };
    let exponent = (((d.abs().max_element().to_bits() >> 23) & 0xff) as i32 - 127).clamp(-125, 125);
    let scale = f32::from_bits(((127 - exponent) as u32) << 23);
    let to_caller = f64::from(scale) * 2f64.powi(extra);
    let t_max = (f64::from(ray.t_max) / to_caller) as f32;
    Some((Ray { o: ray.o, d: d * scale, t_max }, to_caller as f32))
}

#[derive(Clone, Copy)]
struct Entry {
    near: f32,
    reference: u32,
}

/// What the slab test needs of a ray.
struct Slabs<L> {
    o: [L; 3],
    inverse: [L; 3],
    /// Which of the two planes of an axis is entered first.
    near: [usize; 3],
}

impl<L: Lanes> Slabs<L> {
    #[inline(always)]
    fn new(o: Vec3, d: Vec3) -> Self {
        let r = Vec3::ONE / d;
        let near = |k: usize| 2 * k + usize::from(r[k].is_sign_negative());
        Self {
            o: [L::splat(o.x), L::splat(o.y), L::splat(o.z)],
            inverse: [L::splat(r.x), L::splat(r.y), L::splat(r.z)],
            near: [near(0), near(1), near(2)],
        }
    }

    #[inline(always)]
    fn at(&self, node: &Node, k: usize, plane: usize) -> L {
        L::load(&node.bounds[plane]).sub(self.o[k]).mul(self.inverse[k])
    }

    /// Entry distances, and the lanes whose box is entered at or before `limit`.
    #[inline(always)]
    fn enter(&self, node: &Node, limit: f32) -> (L, u32) {
        let near = self.at(node, 0, self.near[0]).max(L::splat(0.0));
        let near = self.at(node, 1, self.near[1]).max(near);
        let near = self.at(node, 2, self.near[2]).max(near);
        let far = self.at(node, 0, self.near[0] ^ 1).min(L::splat(f32::INFINITY));
        let far = self.at(node, 1, self.near[1] ^ 1).min(far);
        let far = self.at(node, 2, self.near[2] ^ 1).min(far);
        let far = far.mul(L::splat(WIDEN));
        (near, near.le(far) & near.le(L::splat(limit)))
    }
}

#[inline(always)]
fn walk<L: Lanes, C: Candidate, const ANY: bool>(
    tree: &Tree,
    ray: &Ray,
    scale: f32,
    candidate: &C,
    stack: &mut [MaybeUninit<Entry>],
) -> Option<TriangleHit> {
    let sheared = Sheared::new(ray);
    let slabs = Slabs::<L>::new(ray.o, ray.d);
    let mut best: Option<TriangleHit> = None;
    let mut limit = ray.t_max;
    let mut height = 1;
    stack[0] = MaybeUninit::new(Entry { near: 0.0, reference: tree.root });
    while height > 0 {
        height -= 1;
        // SAFETY: every entry below `height` was written before `height` rose above it.
        let entry = unsafe { stack[height].assume_init() };
        if entry.near > limit * WIDEN {
            continue;
        }
        if entry.reference & LEAF != 0 {
            let block = &tree.blocks[(entry.reference & !LEAF) as usize];
            let found = intersect::<L>(&sheared, block, limit);
            let mut mask = found.mask;
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                let Some(hit) = found.hit(&sheared, block, lane) else { continue };
                let nearer = hit.t < limit || best.is_some_and(|b| hit.t == b.t && hit.triangle < b.triangle);
                if nearer && (C::OPAQUE || candidate.accept(&TriangleHit { t: hit.t * scale, ..hit })) {
                    if ANY {
                        return Some(hit);
                    }
                    limit = hit.t;
                    best = Some(hit);
                }
            }
        } else {
            let node = &tree.nodes[entry.reference as usize];
            let (near, mask) = slabs.enter(node, limit * WIDEN);
            push::<L, ANY>(node, near, mask, stack, &mut height);
        }
    }
    best
}

/// Pushes the entered children, the nearest on top (any order for shadow rays).
#[inline(always)]
fn push<L: Lanes, const ANY: bool>(
    node: &Node,
    near: L,
    mut mask: u32,
    stack: &mut [MaybeUninit<Entry>],
    height: &mut usize,
) {
    let mut distances = [0.0; 8];
    near.store(&mut distances);
    let base = *height;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        let entry = Entry { near: distances[lane], reference: node.child[lane] };
        let mut at = *height;
        if !ANY {
            // SAFETY: entries in base..height were written in this call.
            while at > base && unsafe { stack[at - 1].assume_init() }.near < entry.near {
                stack[at] = stack[at - 1];
                at -= 1;
            }
        }
        stack[at] = MaybeUninit::new(entry);
        *height += 1;
    }
}
