//! How does a file become a picture?
//!
//! The content decides the format, the extension only where the content says nothing. sRGB files (PNG, JPEG, WebP)
//! are decoded to linear light with the exact curve. Embedded colour profiles, gamma chunks, orientation tags and
//! the EXPOSURE line of an .hdr are ignored: code values are taken as sRGB, numbers as they are. Alpha is left out
//! of pictures. Values that are not finite (only EXR can hold them) are handed on: the caller decides.
//!
//! *Approximation*: JPEG and EXR's DWAA and DWAB are decoded by kernels that may differ in the last bit between
//! machines; all other formats and compressions give every machine the same numbers.
//!
//! No content makes these functions panic, or allocate more than [`MAX_PIXELS`] and [`MAX_SAMPLES`] allow. Those that
//! take a [`MemoryLimit`](crate::MemoryLimit) work out what decoding will take before it begins, and refuse what is over
//! the limit.

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
