//! The glTF 2.0 reader.
use crate::{SceneBuilder, SceneError};
use std::path::Path;
#[derive(Clone, Debug, Default)]
pub struct Options {
    /** seconds at which animation is evaluated */
    pub at: f64,
    /** read files outside the scene's folder */
    pub allow_path: bool,
}
/// Reads .gltf or .glb into a builder (to which an environment may still be added).
pub fn read(_path: &Path, _options: &Options) -> Result<SceneBuilder, SceneError> {
    todo!()
}
/// What is in the file, for `dapple info`.
pub fn info(_path: &Path, _options: &Options) -> Result<Info, SceneError> {
    todo!()
}
/// Counts and names; see fields.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Info {}
