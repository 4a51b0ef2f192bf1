//! Everything rays can hit, behind two queries.
//!
//! Static meshes share one flattened tree. Beside it, in a second level that exists only when it is needed, stand
//! exact shapes, instances and whatever moves: a tree over boxes that hold for the whole shutter; the ray goes into
//! each object's own space with the transform at the ray's time, its direction not made unit, so that t is shared.
//! At equal distance the lowest object, then the lowest triangle wins, whatever the trees look like.
mod builder;
mod coincident;
mod objects;
mod queries;
mod second;

pub use builder::AccelBuilder;
pub use coincident::{Coincident, PlacePoint};

pub use queries::Accel;
