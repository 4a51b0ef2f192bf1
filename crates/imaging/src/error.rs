//! What can go wrong with a picture file? Each error names the file and what to do about it.

use crate::memory::Overrun;
use crate::window::Partial;
use std::path::PathBuf;

/// A picture that cannot be read or written.
///
/// Where bytes did not come from a file of their own (a texture inside a .glb), `name` is what the caller
/// called them.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// Nothing is there.
    #[error("{name}: no such file; check the path")]
    Missing {
        /// The file.
        name: String,
    },
    /// A folder or device where a plain file is needed.
    #[error("{name}: is not a plain file; name a picture file")]
    NotAFile {
        /// The path.
        name: String,
    },
    /// The system refused to read.
    #[error("{name}: cannot be read: {source}")]
    Read {
        /// The file.
        name: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// Neither content nor extension says which kind of picture this is.
    #[error("{name}: is no picture that can be read here; convert it to EXR, HDR, PNG, JPEG or WebP")]
    NotAPicture {
        /// The file.
        name: String,
    },
    /// Cut short or damaged.
    #[error("{name}: is damaged or cut short ({why}); export or download it again")]
    Malformed {
        /// The file.
        name: String,
        /// What the decoder found.
        why: String,
    },
    /// A valid file with something in it that is not supported.
    #[error("{name}: {what} is not supported; save the picture without it")]
    Unsupported {
        /// The file.
        name: String,
        /// The feature.
        what: String,
    },
    /// This build leaves the format out.
    #[error("{name}: this build leaves out {format} files; build with the feature `{feature}`")]
    NotBuiltIn {
        /// The file.
        name: String,
        /// The format.
        format: &'static str,
        /// The Cargo feature that brings it.
        feature: &'static str,
    },
    /// More pixels or samples than [`MAX_PIXELS`](crate::read::MAX_PIXELS) and
    /// [`MAX_SAMPLES`](crate::read::MAX_SAMPLES) allow.
    #[error("{name}: {width}×{height} with {channels} channels is too large; scale it down")]
    TooLarge {
        /// The file.
        name: String,
        /// Pixels per row.
        width: u64,
        /// Rows.
        height: u64,
        /// Channels that would have to be held in memory.
        channels: u64,
    },
    /// More memory than there is, or than suits the size of the file.
    #[error("{name}: reading its {width}×{height} pixels {overrun}")]
    Memory {
        /// The file.
        name: String,
        /// Pixels per row.
        width: u64,
        /// Rows.
        height: u64,
        /// What is needed and what there is.
        overrun: Overrun,
    },
    /// A picture that is nearly nothing but frame: the data window covers a tiny part of a large display window.
    #[error(
        "{name}: holds {held} pixels in a frame of {width}×{height}; save it with a display window that fits what is in it"
    )]
    Sparse {
        /// The file.
        name: String,
        /// Pixels of the data window.
        held: u64,
        /// Pixels per row of the display window.
        width: u64,
        /// Its rows.
        height: u64,
    },
    /// A crop where more of the picture is needed.
    #[error("{0}")]
    Partial(Box<Partial>),
    /// The extension of an output says no known format.
    #[error("{}: unknown extension; use .exr, .png or .hdr", .0.display())]
    UnknownExtension(PathBuf),
    /// The folder of an output is not there.
    #[error("{}: the folder {} does not exist; create it first", path.display(), folder.display())]
    NoFolder {
        /// The output.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The system refused to write.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The output.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// What is to be written is no picture: sizes that contradict one another, or names the format cannot hold.
    #[error("{}: cannot be written: {why}", path.display())]
    Inconsistent {
        /// The output.
        path: PathBuf,
        /// The contradiction.
        why: String,
    },
}
