//! Which surfaces lie in one place with an emitter, and when are two hits of a ray one place?
//!
//! Positions are known up to an error bound. Two surfaces that are nearer to each other than their bounds cannot be
//! told apart: which of them a ray meets first is rounding. Such hits are *one place*, and who asks for light decides by
//! a rule which of the surfaces is there. [`Accel::coincident`] finds once, when a scene is loaded, the primitives for
//! which that question can arise: those asked about (emitters, and what light passes) on which another surface lies, those
//! surfaces, the points (of point and spot lights) that lie in a surface, and triangles of two objects that let no light
//! through.
mod opaque;
mod outline;
mod search;

use super::queries::Accel;
use crate::{Hit, Surface};
use glam::{DVec3, Vec3};

/// The primitives and points of a world that share a place with one that was asked about.
#[derive(Clone, Debug)]
pub struct Coincident {
    /// Per object: where the bits of its primitives start in `bits`, or `NONE`, or `WHOLE`.
    starts: Vec<u32>,
    bits: Vec<u64>,
    points: Vec<bool>,
    thickness: f32,
    origin_error: Vec3,
}

/// No primitive of the object.
const NONE: u32 = u32::MAX;
/// All of its primitives.
const WHOLE: u32 = u32::MAX - 1;

impl Coincident {
    /// Whether a primitive was asked about and has something in the same place, or lies there.
    #[inline]
    pub fn contains(&self, object: u32, primitive: u32) -> bool {
        match self.starts.get(object as usize) {
            None | Some(&NONE) => false,
            Some(&WHOLE) => true,
            Some(&start) => {
                let word = self.bits.get(start as usize + (primitive / 64) as usize);
                word.is_some_and(|word| word >> (primitive % 64) & 1 == 1)
            }
        }
    }

    /// Whether point number `i` of the search lies in a surface.
    pub fn contains_point(&self, i: usize) -> bool {
        self.points.get(i).copied().unwrap_or(false)
    }

    /// Along a normal, hits of contained primitives that are one place are at most this far apart, in render units.
    pub fn thickness(&self) -> f32 {
        self.thickness
    }

    /// A hit's point with the bound of its error.
    pub fn point(&self, accel: &Accel, hit: &Hit, surface: &Surface, time: f32) -> PlacePoint {
        let error = accel
            .objects
            .get(hit.object as usize)
            .map_or(surface.p_error.as_dvec3(), |object| object.coincidence_error(surface, accel.held(time)));
        PlacePoint::new(surface.p, surface.ng, error.as_vec3(), self)
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.bits) + self.points.len()
    }
}

/// A point of a surface, its unit normal, and the bound of its error per axis.
#[derive(Clone, Copy, Debug)]
pub struct PlacePoint {
    p: DVec3,
    n: DVec3,
    error: DVec3,
}

impl PlacePoint {
    /// `error`: bound of |computed − exact| per axis, without what the coordinates came with.
    pub fn new(p: Vec3, n: Vec3, error: Vec3, coincident: &Coincident) -> Self {
        let error = error.as_dvec3() + coincident.origin_error.as_dvec3();
        Self { p: p.as_dvec3(), n: n.as_dvec3(), error }
    }

    /// Bound of the error per axis.
    pub fn error(&self) -> Vec3 {
        self.error.as_vec3()
    }

    /// Whether the two hits of one ray are one place: each lies in the plane of the other within both error bounds. The
    /// distance is that from the plane, not that along the ray, which grows without limit where the ray grazes.
    pub fn is_one_with(&self, other: &Self) -> bool {
        let apart = other.p - self.p;
        let bound = self.error + other.error;
        let near = |n: DVec3| n.dot(apart).abs() <= n.abs().dot(bound);
        near(self.n) && near(other.n)
    }

    /// Whether the plane here passes through `q` within the error bounds of both.
    pub fn holds(&self, q: Vec3, q_error: Vec3) -> bool {
        let bound = self.error + q_error.as_dvec3();
        self.n.dot(q.as_dvec3() - self.p).abs() <= self.n.abs().dot(bound)
    }
}
