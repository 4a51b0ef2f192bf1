//! Rays, frames, motion, error bounds and images: the types shared by all other crates of the renderer.
//!
//! - [`Ray`]: an origin, a direction and an exclusive end.
//! - [`Frame`]: an orthonormal basis and its conversions to and from local coordinates.
//! - [`Motion`], [`motion::Pose`], [`motion::Track`]: key-framed node transforms and their inverses, in f64.
//! - [`offset`]: bounds of rounding errors (γₙ), and ray origins that avoid self-intersection without an epsilon.
//! - [`Aabb`]: axis-aligned bounding boxes.
//! - [`ExactSum`], [`FixedSum`]: sums that do not depend on the order of summation.
//! - [`lanes`]: numbers of 1, 8 or 16 lanes, vectors and elementary functions over them, all with the same bits.
//! - [`Image`], [`PixelRect`]: images in linear colour, and rectangles of pixels.
//!
//! The crate does not depend on surfaces, lights, materials or files. [`glam`] is re-exported because its vectors are
//! part of most signatures.
#![deny(unsafe_code)]

pub mod aabb;
pub mod exact_sum;
pub mod fixed_sum;
pub mod frame;
pub mod image;
pub mod lanes;
pub mod motion;
pub mod offset;
pub mod ray;
pub mod rect;
pub mod vector;

pub use aabb::Aabb;
pub use exact_sum::ExactSum;
pub use fixed_sum::{FixedSum, FixedVector};
pub use frame::Frame;
pub use glam;
pub use image::Image;
pub use motion::Motion;
pub use ray::Ray;
pub use rect::PixelRect;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
