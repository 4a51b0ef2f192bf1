//! Pictures to files: written beside the target under a temporary name, then renamed.
use crate::{ImageError, Layers, Picture, Tone};
use std::path::Path;
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Depth {
    #[default]
    Float,
    Half,
}
pub fn exr(_path: &Path, _layers: &Layers, _depth: Depth) -> Result<(), ImageError> {
    todo!()
}
pub fn png(_path: &Path, _picture: &Picture, _tone: Tone, _exposure: f32) -> Result<(), ImageError> {
    todo!()
}
pub fn hdr(_path: &Path, _picture: &Picture) -> Result<(), ImageError> {
    todo!()
}
/// Fails early when `path` cannot be written (missing folder, no permission, unknown extension).
pub fn check(_path: &Path) -> Result<(), ImageError> {
    todo!()
}
