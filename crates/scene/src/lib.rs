//! One checked picture: geometry, materials, lights and cameras, read from glTF or built in code.
pub mod builder;
pub mod builtin;
pub mod emission;
pub mod error;
#[cfg(feature = "gltf")]
pub mod gltf;
pub mod material;
pub mod scene;
pub mod space;
pub mod survey;
pub use builder::SceneBuilder;
pub use error::{SceneError, Warning};
pub use material::{AlphaMode, TexturedMaterial};
pub use scene::{NamedCamera, Object, Scene, Shading};
pub use space::Space;
pub use survey::Survey;
