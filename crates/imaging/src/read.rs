//! Reading of image files.
//!
//! The format is detected from the content, and from the extension only if the content is inconclusive. sRGB files
//! (PNG, JPEG, WebP) are decoded to linear light with the exact curve. Embedded colour profiles, gamma chunks,
//! orientation tags and the EXPOSURE line of an .hdr are ignored: code values are interpreted as sRGB, and numbers are
//! used unchanged. Images have no alpha. Non-finite values (which only EXR can contain) are left to the caller.
//!
//! *Approximation*: JPEG and EXR's DWAA and DWAB are decoded by kernels that may differ in the last bit between
//! machines; all other formats and compressions give the same numbers on every machine.
//!
//! No file content makes these functions panic or allocate more than [`MAX_PIXELS`] and [`MAX_SAMPLES`] allow. The
//! functions that take a [`MemoryLimit`](crate::MemoryLimit) compute the memory needed for decoding in advance, and
//! return an error if it exceeds the limit.

mod bytes;
mod decoders;
#[cfg(feature = "exr")]
mod exr;
mod files;
mod jpeg;
mod kind;
mod limits;
#[cfg(feature = "png")]
mod raster;
mod texels;

pub use bytes::{rgba8, rgba8_within, size, texels, texels_within};
pub use files::{channels, layers, picture, picture_within, pixel_count, windowed, windowed_within};
pub use jpeg::{Gap, gap};
pub use limits::{MAX_PIXELS, MAX_SAMPLES};
pub use texels::{Rgba8, Rgba16, Texels};
