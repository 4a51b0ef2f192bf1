//! A ray as traversal takes it: in the units of the tree, and of a length that arithmetic can bear.

use super::Tree;
use crate::Ray;
use glam::Vec3A;

/// Stands for 1/0. The padding alone takes a ray longer to cross than anything is away, unless that is 1e27 times
/// further than the triangle is large.
const STEEPEST: f32 = f32::MAX / 2.0;

/// The largest coordinate of directions that are taken as they are lies between this and its inverse.
const LONG: f32 = (1u32 << 16) as f32;

/// A ray in the tree's units.
#[derive(Clone, Copy)]
pub(super) struct Query {
    pub o: Vec3A,
    pub d: Vec3A,
    /// Largest coordinate of d.
    largest: f32,
    pub t_max: f32,
    /// Factor from its t to the caller's.
    pub to_caller: f64,
}

impl Query {
    /// None where nothing can be hit. All stays in registers: a ray that misses everything spends its time here.
    #[inline(always)]
    pub fn new(tree: &Tree, ray: &Ray) -> Option<Self> {
        let (o, d) = (Vec3A::from(ray.o) * tree.scale, Vec3A::from(ray.d));
        let largest = d.abs().max_element();
        // NaN unless all are finite.
        let zero = o.dot(Vec3A::ZERO) + d.dot(Vec3A::ZERO);
        (largest > zero && ray.t_max > zero).then_some(Self {
            o,
            d,
            largest,
            t_max: ray.t_max * tree.scale,
            to_caller: tree.unscale,
        })
    }

    /// Whether no product of the traversal leaves the range of f32.
    #[inline(always)]
    pub fn in_range(&self) -> bool {
        self.largest < LONG && self.largest > 1.0 / LONG
    }

    /// `ray` with a direction near unit length. It differs by a power of two, which changes no bit of a hit.
    pub fn shortened(self, tree: &Tree, ray: &Ray) -> Self {
        let exponent = (self.largest.to_bits() >> 23).clamp(1, 253);
        let (length, shrink) = (f32::from_bits(exponent << 23), f32::from_bits((254 - exponent) << 23));
        Self {
            d: self.d * shrink,
            t_max: (f64::from(ray.t_max) * (f64::from(tree.scale) * f64::from(length))) as f32,
            to_caller: f64::from(shrink) * tree.unscale,
            ..self
        }
    }

    /// 1/d, finite.
    #[inline(always)]
    pub fn inverse(&self) -> Vec3A {
        (Vec3A::ONE / self.d).clamp(Vec3A::splat(-STEEPEST), Vec3A::splat(STEEPEST))
    }
}
