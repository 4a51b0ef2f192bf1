//! The glTF 2.0 reader: .gltf and .glb to a [`SceneBuilder`].
//!
//! The crate `gltf` parses the JSON; everything it would trust the file with is done here: splitting the .glb,
//! required extensions, every index, byte range and count, the node graph, files and images. Whatever bytes a file
//! has, reading it ends in a scene or in one [`SceneError`] that says where and why.
mod accessor;
mod animation;
mod choose;
mod container;
mod document;
mod enumerations;
mod extensions;
mod info;
mod instancing;
mod load;
mod material;
mod mend;
mod mesh;
mod node;
mod read;
mod source;
mod texture;
mod visible;

use crate::{LightUnit, Reads, SceneBuilder, SceneError};
pub use choose::Choice;
use container::Required;
use dapple_camera::Shutter;
use dapple_imaging::MemoryLimit;
use document::Document;
pub use info::{
    AnimationInfo, CameraInfo, Counts, EmissiveInfo, ExtensionInfo, Info, LightInfo, LightUnitInfo,
    MorphInfo, ObjectInfo, SceneInfo, SkinInfo, TextureInfo, VariantInfo,
};
use std::path::Path;

/// How to read a file.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Seconds at which animation is evaluated.
    pub at: f64,
    /// When the picture is exposed, counted from `at`; what moves meanwhile is blurred.
    pub shutter: Shutter,
    /// Read files outside the scene's folder.
    pub allow_path: bool,
    /// Refuse a file that names an image which is not there, instead of leaving the texture out.
    pub strict: bool,
    /// What is looked at; the rest is not read.
    pub reads: Reads,
    /// How much memory the scene may take.
    pub memory: MemoryLimit,
    /// Which scene, variant and animation.
    pub choice: Choice,
    /// The unit of the punctual lights.
    pub light_unit: LightUnit,
}

/// Reads .gltf or .glb into a builder (to which an environment may still be added).
///
/// # Errors
/// What cannot be read, is not valid, or needs an extension that is not supported.
pub fn read(path: &Path, options: &Options) -> Result<SceneBuilder, SceneError> {
    read::scene(&parse(path, &file(path, options)?, Required::Refused, options)?)
}

/// As [`read`], from the bytes of the file; `path` is what messages call it and where it finds other files.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(path: &Path, bytes: &[u8], options: &Options) -> Result<SceneBuilder, SceneError> {
    read::scene(&parse(path, bytes, Required::Refused, options)?)
}

/// What is in the file, for `dapple info`. Extensions that are required but not supported are listed, not refused.
///
/// # Errors
/// As [`read`].
pub fn info(path: &Path, options: &Options) -> Result<Info, SceneError> {
    info::info(&parse(path, &file(path, options)?, Required::Warned, options)?)
}

/// The file itself and the files that its buffers and images name, read or not; nothing but the JSON is looked at.
///
/// # Errors
/// As [`read`].
pub fn files(path: &Path, options: &Options) -> Result<Vec<std::path::PathBuf>, SceneError> {
    Ok(parse(path, &file(path, options)?, Required::Warned, options)?.files())
}

fn file(path: &Path, options: &Options) -> Result<Vec<u8>, SceneError> {
    let io = |source| SceneError::Io { file: path.to_owned(), what: "the scene".into(), source };
    let length = std::fs::metadata(path).map_err(io)?.len();
    let memory = |overrun| SceneError::Memory { file: path.to_owned(), place: "the file".into(), overrun };
    options.memory.admit(length, None).map_err(memory)?;
    std::fs::read(path).map_err(io)
}

fn parse<'o>(
    path: &Path,
    bytes: &[u8],
    required: Required,
    options: &'o Options,
) -> Result<Document<'o>, SceneError> {
    let mut warnings = Vec::new();
    let content = container::parse(path, bytes, required, options, &mut warnings)?;
    Ok(Document::new(path, options, content, warnings))
}
