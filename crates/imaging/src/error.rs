//! What can go wrong with a picture file; each names the file and the remedy.

use std::path::{Path, PathBuf};

/// An unreadable, unwritable or malformed picture.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file cannot be opened.
    #[error("{}: cannot be read ({source}); check the path", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The bytes are no picture that we know, or a damaged one.
    #[error("{name}: not a usable picture ({why}); use a complete .exr, .hdr, .png, .jpg or .webp")]
    Malformed {
        /// File or object.
        name: String,
        /// What the decoder says.
        why: String,
    },
    /// Larger than any decoder here will allocate for.
    #[error(
        "{name}: {width}x{height} pixels are more than the {limit} that are read; scale the picture down"
    )]
    TooLarge {
        /// File or object.
        name: String,
        /// Pixels across.
        width: u64,
        /// Pixels down.
        height: u64,
        /// Most pixels accepted.
        limit: u64,
    },
    /// The extension says nothing we can write.
    #[error("{}: unknown kind of picture; end the name in .exr, .png or .hdr", .0.display())]
    UnknownExtension(PathBuf),
    /// The format was left out of this build.
    #[error("{name}: this build has no {format} support; build with the feature '{feature}'")]
    NotBuiltIn {
        /// File or object.
        name: String,
        /// Which format.
        format: &'static str,
        /// Which Cargo feature brings it.
        feature: &'static str,
    },
    /// The file cannot be written.
    #[error("{}: cannot be written ({source}); check the folder and its permissions", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The picture's parts do not fit together.
    #[error("{}: {why}", path.display())]
    Inconsistent {
        /// The file to be written.
        path: PathBuf,
        /// What does not fit.
        why: String,
    },
}

impl ImageError {
    pub(crate) fn malformed(name: impl ToString, why: impl ToString) -> Self {
        Self::Malformed { name: name.to_string(), why: why.to_string() }
    }

    pub(crate) fn write(path: &Path, source: impl Into<std::io::Error>) -> Self {
        Self::Write { path: path.into(), source: source.into() }
    }
}
