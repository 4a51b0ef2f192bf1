//! Entry points of the reader: read the scene, summarise the contents, list the files that a scene consists of.
use super::container::{self, Required};
use super::document::Document;
use super::info::{self, Info};
use super::options::Options;
use super::read::scene;
use crate::{SceneBuilder, SceneError};
use std::io::Read;
use std::path::Path;

/// Reads a .gltf or .glb file into a builder, to which an environment may still be added.
///
/// # Errors
/// If the file cannot be read, is not valid, or requires an extension that is not supported.
pub fn read(path: &Path, options: &Options) -> Result<SceneBuilder, SceneError> {
    scene(&parse(path, &file(path, options)?, Required::Refused, options)?)
}

/// As [`read`], from the bytes of the file. `path` is its name in messages, and other files are found relative to it.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(path: &Path, bytes: &[u8], options: &Options) -> Result<SceneBuilder, SceneError> {
    scene(&parse(path, bytes, Required::Refused, options)?)
}

/// Summarises the contents of a file, for `dapple info`. Required extensions that are not supported are listed rather
/// than treated as errors.
///
/// # Errors
/// As [`read`].
pub fn info(path: &Path, options: &Options) -> Result<Info, SceneError> {
    info::info(&parse(path, &file(path, options)?, Required::Warned, options)?)
}

/// Lists the file itself and the files that its buffers and images name, used or not. Only the JSON is read.
///
/// # Errors
/// As [`read`].
pub fn files(path: &Path, options: &Options) -> Result<Vec<std::path::PathBuf>, SceneError> {
    Ok(parse(path, &file(path, options)?, Required::Warned, options)?.files())
}

fn file(path: &Path, options: &Options) -> Result<Vec<u8>, SceneError> {
    let io = |source| SceneError::Io { file: path.to_owned(), what: "the scene".into(), source };
    let about = std::fs::metadata(path).map_err(io)?;
    // Reading a device or a pipe might never end.
    if !about.is_file() {
        return Err(io(std::io::Error::other("it is not a regular file")));
    }
    let memory = |overrun| SceneError::Memory { file: path.to_owned(), place: "the file".into(), overrun };
    options.memory.admit(about.len(), None).map_err(memory)?;
    let mut bytes = Vec::new();
    std::fs::File::open(path).and_then(|file| file.take(about.len()).read_to_end(&mut bytes)).map_err(io)?;
    Ok(bytes)
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
