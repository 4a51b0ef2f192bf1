//! The acceleration structure over all objects, with two queries.
//!
//! Static meshes share one flattened BVH. Exact shapes, instances and moving objects are in a second level, which
//! exists only when it is needed: a BVH over bounding boxes that are valid for the whole shutter interval. A ray is
//! transformed into the space of each object at the ray's time; its direction is not normalised, so that t is the same
//! in both spaces. At equal distance the lowest object, then the lowest triangle is hit, independently of the structure
//! of the trees.
mod builder;
mod coincident;
mod facets;
mod objects;
mod queries;
mod second;

pub use builder::AccelBuilder;
pub use coincident::{Coincident, PlacePoint};
pub use facets::{Facets, Surfaces};
pub use queries::Accel;
