//! Errors of reading and writing image files. Each message names the file and a remedy.

use crate::memory::Overrun;
use crate::window::Partial;
use std::path::PathBuf;

/// The error type for images that cannot be read or written.
///
/// For bytes that are not a separate file (a texture inside a .glb), `name` is the name given by the caller.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The file does not exist.
    #[error("{name}: no such file; check the path")]
    Missing {
        /// The file.
        name: String,
    },
    /// The path is a folder or a device, but a regular file is required.
    #[error("{name}: is not a regular file; give the path of an image file")]
    NotAFile {
        /// The path.
        name: String,
    },
    /// The operating system reported an error on reading.
    #[error("{name}: cannot be read: {source}")]
    Read {
        /// The file.
        name: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// Neither content nor extension identifies a known image format.
    #[error("{name}: has an unknown image format; convert it to EXR, HDR, PNG, JPEG or WebP")]
    NotAPicture {
        /// The file.
        name: String,
    },
    /// The file is damaged or truncated.
    #[error("{name}: is damaged or truncated ({why}); export or download it again")]
    Malformed {
        /// The file.
        name: String,
        /// The reason given by the decoder.
        why: String,
    },
    /// The file is valid but uses a feature that is not supported.
    #[error("{name}: {what} is not supported; save the image without it")]
    Unsupported {
        /// The file.
        name: String,
        /// The unsupported feature.
        what: String,
    },
    /// This build does not support the format.
    #[error("{name}: this build does not support {format} files; build with the feature `{feature}`")]
    NotBuiltIn {
        /// The file.
        name: String,
        /// The format.
        format: &'static str,
        /// The Cargo feature that enables it.
        feature: &'static str,
    },
    /// The image has more pixels or samples than [`MAX_PIXELS`](crate::read::MAX_PIXELS) and
    /// [`MAX_SAMPLES`](crate::read::MAX_SAMPLES) allow.
    #[error("{name}: {width}×{height} with {channels} channels is too large; scale it down")]
    TooLarge {
        /// The file.
        name: String,
        /// Pixels per row.
        width: u64,
        /// Rows.
        height: u64,
        /// Number of channels to be held in memory.
        channels: u64,
    },
    /// Reading requires more memory than is free, or more than is allowed for the size of the file.
    #[error("{name}: reading its {width}×{height} pixels {overrun}")]
    Memory {
        /// The file.
        name: String,
        /// Pixels per row.
        width: u64,
        /// Rows.
        height: u64,
        /// The required and the allowed memory.
        overrun: Overrun,
    },
    /// The data window covers only a tiny part of a large display window.
    #[error(
        "{name}: has data for {held} pixels in a display window of {width}×{height}; save it with a smaller one"
    )]
    Sparse {
        /// The file.
        name: String,
        /// Number of pixels in the data window.
        held: u64,
        /// Pixels per row of the display window.
        width: u64,
        /// Rows of the display window.
        height: u64,
    },
    /// A crop does not contain all required pixels.
    #[error("{0}")]
    Partial(Box<Partial>),
    /// The extension of an output is not that of a known format.
    #[error("{}: unknown extension; use .exr, .png or .hdr", .0.display())]
    UnknownExtension(PathBuf),
    /// The folder of an output does not exist.
    #[error("{}: the folder {} does not exist; create it first", path.display(), folder.display())]
    NoFolder {
        /// The output.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The operating system reported an error on writing.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The output.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The data to be written are inconsistent, or contain names that the format cannot represent.
    #[error("{}: cannot be written: {why}", path.display())]
    Inconsistent {
        /// The output.
        path: PathBuf,
        /// The reason.
        why: String,
    },
}
