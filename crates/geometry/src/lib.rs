//! What a ray hits, and what is there.
//!
//! Two queries, [`Accel::intersect`] and [`Accel::occluded`], return ids and barycentrics; positions, normals and
//! attributes are asked for later, only where they are needed. There is no epsilon: hit points carry the bound of
//! their own rounding error, and rays start outside it.
#![deny(unsafe_code)]

pub mod accel;
mod boxes;
pub mod bvh;
pub mod hit;
pub mod mesh;
pub mod shapes;
pub mod surface;

pub use accel::{Accel, AccelBuilder, Coincident, PlacePoint};
pub use bvh::{HitFilter, Opaque};
pub use dapple_math as math;
pub use hit::Hit;
pub use mesh::Mesh;
pub use surface::Surface;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
