//! How does a picture become a file?
//!
//! Every file is written under a temporary name beside its target and renamed when it is whole: whoever looks at
//! the target sees the old file or the new one, never a part, and a failure leaves nothing behind; what a killed
//! process leaves, [`check`] removes the next time. The bytes
//! depend on the picture alone: not on machine, thread count, time or path.

#[cfg(feature = "exr")]
mod exr;
mod file;
mod format;
mod hdr;
mod options;
mod pictures;
#[cfg(feature = "png")]
mod png;

pub use file::{elsewhere, probe, replace};
pub use format::Format;
pub use options::{Depth, PngDepth, PngOptions};
pub use pictures::{check, code_values, exr, hdr, png, png_with, rgb8};
