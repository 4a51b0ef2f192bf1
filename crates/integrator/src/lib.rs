//! The two tracers, composed of the parts, and the render loop. Re-exports the parts as modules.
pub use dapple_camera as camera;
pub use dapple_geometry as geometry;
pub use dapple_imaging as imaging;
pub use dapple_lights as lights;
pub use dapple_materials as materials;
pub use dapple_sampling as sampling;
pub use dapple_scene as scene;
pub mod aov;
pub mod render;
pub mod replay;
pub mod settings;
pub use aov::Aov;
pub use render::{Outcome, Progress, Stats, render};
pub use replay::{PathVertex, replay};
pub use settings::{Method, Settings};
