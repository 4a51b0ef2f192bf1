//! Detection of coincident surfaces: which surfaces share a place with an emitter, and which hits of a ray are at the
//! same place.
//!
//! Positions are known up to an error bound. Two surfaces whose distance is less than the sum of their bounds cannot be
//! distinguished: which of them a ray hits first depends on rounding. Such hits are at *one place*, and the light
//! transport code decides by a rule which of the surfaces is there. [`Accel::coincident`] runs once when a scene is
//! loaded and finds the primitives that can be affected: query primitives (emitters and surfaces that transmit light)
//! that coincide with another surface, those other surfaces, the positions of point and spot lights that lie in a
//! surface, and coincident triangles of two opaque objects.
mod opaque;
mod outline;
mod search;

use super::queries::Accel;
use crate::{Hit, Surface};
use glam::{DVec3, Vec3};

/// The primitives and points of a scene that share a place with a query primitive.
#[derive(Clone, Debug)]
pub struct Coincident {
    /// Per object: the index in `bits` of its primitives' first word, or `NONE`, or `WHOLE`.
    starts: Vec<u32>,
    bits: Vec<u64>,
    points: Vec<bool>,
    thickness: f32,
    origin_error: Vec3,
}

/// No primitive of the object is contained.
const NONE: u32 = u32::MAX;
/// All primitives of the object are contained.
const WHOLE: u32 = u32::MAX - 1;

impl Coincident {
    /// Whether a primitive is a query primitive that coincides with another surface, or is such a surface.
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

    /// Whether point number `i` of the query lies in a surface.
    pub fn contains_point(&self, i: usize) -> bool {
        self.points.get(i).copied().unwrap_or(false)
    }

    /// The largest distance along the normal, in render units, between hits on contained primitives that are at one
    /// place.
    pub fn thickness(&self) -> f32 {
        self.thickness
    }

    /// The point of a hit with its error bound.
    pub fn point(&self, accel: &Accel, hit: &Hit, surface: &Surface, time: f32) -> PlacePoint {
        let error = accel.objects.get(hit.object as usize).map_or(surface.p_error.as_dvec3(), |object| {
            object.coincidence_error(surface, accel.clamped(time))
        });
        PlacePoint::new(surface.p, surface.ng, error.as_vec3(), self)
    }

    /// Memory in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.bits) + self.points.len()
    }
}

/// A surface point with its unit normal and its error bound per axis.
#[derive(Clone, Copy, Debug)]
pub struct PlacePoint {
    p: DVec3,
    n: DVec3,
    error: DVec3,
}

impl PlacePoint {
    /// `error` is the bound of |computed − exact| per axis, without the error that the coordinates had when they were
    /// loaded.
    pub fn new(p: Vec3, n: Vec3, error: Vec3, coincident: &Coincident) -> Self {
        let error = error.as_dvec3() + coincident.origin_error.as_dvec3();
        Self { p: p.as_dvec3(), n: n.as_dvec3(), error }
    }

    /// The error bound per axis.
    pub fn error(&self) -> Vec3 {
        self.error.as_vec3()
    }

    /// Whether two hits of one ray are at one place: each lies in the plane of the other within both error bounds. The
    /// distance from the plane is used because the distance along the ray is unbounded at grazing incidence.
    pub fn is_one_with(&self, other: &Self) -> bool {
        let apart = other.p - self.p;
        let bound = self.error + other.error;
        let near = |n: DVec3| n.dot(apart).abs() <= n.abs().dot(bound);
        near(self.n) && near(other.n)
    }

    /// Whether the plane of this point passes through `q` within the error bounds of both.
    pub fn holds(&self, q: Vec3, q_error: Vec3) -> bool {
        let bound = self.error + q_error.as_dvec3();
        self.n.dot(q.as_dvec3() - self.p).abs() <= self.n.abs().dot(bound)
    }
}
