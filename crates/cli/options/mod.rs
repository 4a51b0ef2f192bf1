//! The options of a render and what they are made of: effects, view, choices from a file, and what a sidecar said.

mod choice;
mod effects;
mod render;
mod sidecar;
mod view;

pub use effects::EffectOptions;
pub use render::{NO_ENVIRONMENT, RenderOptions, command, ids, names};
pub use sidecar::OfScene;
pub use view::{Orbit, ViewOptions};
