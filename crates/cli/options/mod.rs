//! The options of a render and their parts: effects, view, choices from a file, what long renders save, and the record of sidecar settings.

mod choice;
mod effects;
mod frames;
mod long;
mod render;
mod sidecar;
mod view;

pub use effects::EffectOptions;
pub use frames::Frames;
pub use render::{NO_ENVIRONMENT, RenderOptions, command, ids, names};
pub use sidecar::OfScene;
pub use view::{Orbit, ViewOptions};
