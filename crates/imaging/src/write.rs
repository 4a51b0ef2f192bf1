//! Writing of image files.
//!
//! Every file is written under a temporary name in the folder of its target and renamed when complete. Readers of the
//! target see either the old file or the new one, never a partial one, and a failure leaves no file behind. Temporary
//! files of killed processes are removed by the next [`check`]. The bytes depend only on the image, not on machine,
//! thread count, time or path.

#[cfg(feature = "exr")]
mod exr;
mod file;
mod format;
mod hdr;
mod options;
mod pictures;
#[cfg(feature = "png")]
mod png;

pub use file::{destination, elsewhere, probe, replace};
pub use format::Format;
pub use options::{Depth, PngDepth, PngOptions};
pub use pictures::{check, code_values, exr, hdr, png, png_with, rgb8};
