//! Packets: as many rays at a time as there are lanes, each triangle tested against all of them. Small trees have few
//! boxes that would spare a ray anything, and the lanes of a block of eight triangles are mostly tested in vain.
//!
//! The hits are those of single rays, to the last bit. Which triangle is hit does not depend on the order in which
//! triangles are tested, with one exception: near the ends of a ray, the distance in f32 decides whether a triangle is
//! near enough for its distance to be computed in f64. Rays whose hit lies there are traced again, one by one. Whether
//! a ray is occluded does not depend on the order at all. Rays of a packet have the same main axis, so that they share
//! the order of the axes.

mod columns;
mod hits;
mod packet;
mod queries;

pub(super) use queries::Packets;
