//! Ray intersection with triangle meshes, exact spheres and exact disks, including instances and motion blur.
//!
//! The two queries [`Accel::intersect`] and [`Accel::occluded`] return ids and barycentric coordinates only; positions,
//! normals and attributes are computed on request. No epsilon is used: hit points carry a bound of their rounding
//! error, and rays start outside that bound.
#![deny(unsafe_code)]

pub mod accel;
mod barycentric;
mod boxes;
pub mod bvh;
pub mod hit;
pub mod mesh;
pub mod rays;
pub mod shapes;
mod smooth;
pub mod surface;

pub use accel::{Accel, AccelBuilder, Coincident, Facets, PlacePoint, Surfaces};
pub use bvh::{HitFilter, Opaque};
pub use dapple_math as math;
pub use hit::Hit;
pub use mesh::Mesh;
pub use rays::Rays;
pub use surface::Surface;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
