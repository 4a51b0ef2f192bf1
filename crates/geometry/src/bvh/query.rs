//! The ray as used by traversal: in the units of the tree, with a direction of moderate length.

use super::tree::Tree;
use dapple_math::Ray;
use glam::Vec3A;

/// Replaces 1/0. With this inverse, crossing the padding of a box takes a larger t than reaching any geometry, unless
/// that is 1e27 times as far away as the triangle is large.
pub(super) const STEEPEST: f32 = f32::MAX / 2.0;

/// Directions are used unchanged if their largest coordinate lies between this and its inverse.
pub(super) const LONG: f32 = (1u32 << 16) as f32;

/// A ray in the tree's units, such that no product of the traversal leaves the range of f32.
#[derive(Clone, Copy)]
pub(super) struct Query {
    pub o: Vec3A,
    pub d: Vec3A,
    pub t_max: f32,
    /// Factor from its t to the caller's.
    pub to_caller: f64,
}

impl Query {
    /// The ray with its direction unchanged; None if it can hit nothing, or if the direction is too long or too short.
    #[inline(always)]
    pub fn new(tree: &Tree, ray: &Ray) -> Option<Self> {
        let (o, d) = (Vec3A::from(ray.o) * tree.scale, Vec3A::from(ray.d));
        let (long, short) = (Vec3A::splat(LONG), Vec3A::splat(1.0 / LONG));
        let in_range = d.abs().cmplt(long).all() & d.abs().cmpgt(short).any() & o.is_finite();
        (in_range & (ray.t_max > 0.0)).then_some(Self {
            o,
            d,
            t_max: ray.t_max * tree.scale,
            to_caller: tree.unscale,
        })
    }

    /// The ray with its direction scaled by a power of two to nearly unit length, which changes no bit of a hit. None
    /// if it can hit nothing.
    #[cold]
    pub fn shortened(tree: &Tree, ray: &Ray) -> Option<Self> {
        let o = ray.o * tree.scale;
        let largest = ray.d.abs().max_element();
        if !(o.is_finite() && ray.d.is_finite() && largest > 0.0 && ray.t_max > 0.0) {
            return None;
        }
        let exponent = (largest.to_bits() >> 23).clamp(1, 253);
        let (length, shrink) = (f32::from_bits(exponent << 23), f32::from_bits((254 - exponent) << 23));
        Some(Self {
            o: o.into(),
            d: (ray.d * shrink).into(),
            t_max: (f64::from(ray.t_max) * (f64::from(tree.scale) * f64::from(length))) as f32,
            to_caller: f64::from(shrink) * tree.unscale,
        })
    }

    /// 1/d, finite.
    #[inline(always)]
    pub fn inverse(&self) -> Vec3A {
        (Vec3A::ONE / self.d).clamp(Vec3A::splat(-STEEPEST), Vec3A::splat(STEEPEST))
    }
}
