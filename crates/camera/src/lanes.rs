//! Rays, lens points and filters for 8 or 16 samples at a time, with the same bits as for one: [`Camera::rays`],
//! [`Lens::point_lanes`] and [`FilterWarp`].
//!
//! [`Camera::rays`]: crate::Camera::rays
//! [`Lens::point_lanes`]: crate::Lens::point_lanes

pub use crate::filter::FilterWarp;
pub use crate::view::Rayx;
