//! The distribution ray tracer [Cook 1984]: every effect is an integral of its own, summed where it arises.
//!
//! A pixel is the mean over its area, of the mean over the lens, of the mean over the shutter's time, of the radiance
//! along a ray; and that is, where the ray ends, what is emitted there, plus for each light the mean over its surface,
//! plus for each lobe the mean over its directions of the radiance that comes from there: the same again.
//!
//! Where a light's points and a lobe's directions can both find the same light, they are weighted by the power heuristic
//! with their counts [Veach 1997, §9.2.2].

mod branch;
mod deep;
mod pixel;
mod tree;

pub(crate) use pixel::pixel_point;
pub(crate) use tree::light_plan;
