//! What a ray hits, and what is there.
pub mod bvh;
pub mod frame;
pub mod hit;
pub mod mesh;
pub mod offset;
pub mod ray;
pub mod shapes;
pub mod surface;
pub mod world;
pub use frame::Frame;
pub use hit::Hit;
pub use mesh::Mesh;
pub use ray::Ray;
pub use surface::Surface;
pub use world::{Filter, Opaque, World, WorldBuilder};
