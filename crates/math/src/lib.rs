//! Rays, frames, motion, error bounds and images: the types that every other crate of the renderer shares.
//!
//! - [`Ray`]: an origin, a direction and an exclusive end.
//! - [`Frame`]: an orthonormal basis, to and from local coordinates.
//! - [`Motion`], [`motion::Pose`], [`motion::Track`]: key-framed node transforms and their inverses, in f64.
//! - [`offset`]: bounds of rounding errors (γₙ), and ray origins that need no epsilon.
//! - [`Aabb`]: axis-aligned bounding boxes.
//! - [`Image`], [`PixelRect`]: linear colours per pixel, and rectangles of pixels.
//!
//! Nothing here knows surfaces, lights, materials or files. [`glam`] is re-exported, since its vectors stand in every
//! signature.
#![forbid(unsafe_code)]

pub mod aabb;
pub mod frame;
pub mod image;
pub mod motion;
pub mod offset;
pub mod ray;
pub mod rect;
pub mod vector;

pub use aabb::Aabb;
pub use frame::Frame;
pub use glam;
pub use image::Image;
pub use motion::Motion;
pub use ray::Ray;
pub use rect::PixelRect;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
