//! The distribution ray tracer [Cook 1984]: every effect is a separate integral, evaluated where it arises.
//!
//! A pixel is the mean over its area of the mean over the lens of the mean over the shutter interval of the radiance
//! along a ray. The radiance along a ray is, at the surface it hits, the emission, plus for each light the mean over
//! its surface, plus for each lobe the mean over its directions of the incident radiance, which is computed
//! recursively.
//!
//! Where points on a light and directions of a lobe can both find the same light, they are weighted by the power
//! heuristic with their sample counts [Veach 1997, §9.2.2].

mod branch;
mod deep;
mod pixel;
mod tree;

pub(crate) use pixel::pixel_point;
pub(crate) use tree::light_plan;
