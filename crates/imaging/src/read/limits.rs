//! Limits for the size of images and for the memory of reading them.

use super::kind::Kind;
use crate::memory::{PER_BYTE, PER_HDR_BYTE};
use crate::{ImageError, MemoryLimit};

/// Maximum number of pixels of an image, 2²⁸ = 16384²; larger images are an error before memory is allocated.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Maximum number of values (pixels times channels) of an EXR in memory: 2³⁰, 4 GiB.
pub const MAX_SAMPLES: u64 = 1 << 30;

/// The memory allowed for one file.
#[derive(Clone, Copy, Debug)]
#[allow(dead_code, reason = "unused without any decoder")]
pub(super) struct Room {
    pub limit: MemoryLimit,
    /// Size of the file in bytes.
    pub file: u64,
    /// Bytes of memory that are plausible per byte of the file.
    pub per_byte: u64,
}

#[allow(dead_code, reason = "unused without any decoder")]
impl Room {
    /// The memory allowed for a file of `file` bytes in the format `kind`.
    pub fn new(limit: MemoryLimit, file: u64, kind: Kind) -> Self {
        let per_byte = if kind == Kind::Hdr { PER_HDR_BYTE } else { PER_BYTE };
        Self { limit, file, per_byte }
    }

    /// Checks whether `width` × `height` pixels of `each` bytes, plus `more` bytes, fit into the memory limit.
    pub fn admit(
        &self,
        name: &str,
        [width, height]: [u64; 2],
        each: u64,
        more: u64,
    ) -> Result<(), ImageError> {
        let needed = width.saturating_mul(height).saturating_mul(each).saturating_add(more);
        let refuse = |overrun| ImageError::Memory { name: name.to_string(), width, height, overrun };
        self.limit.admit_by(needed, Some(self.file), self.per_byte).map_err(refuse)
    }
}

/// Checks whether an image of this size is within the limits.
#[allow(dead_code, reason = "unused without any decoder")]
pub(super) fn check_size(name: &str, width: u64, height: u64, channels: u64) -> Result<(), ImageError> {
    let pixels = width.saturating_mul(height);
    if pixels == 0 {
        let why = format!("its size is {width}×{height}");
        return Err(ImageError::Malformed { name: name.to_string(), why });
    }
    if pixels > MAX_PIXELS || pixels.saturating_mul(channels) > MAX_SAMPLES {
        return Err(ImageError::TooLarge { name: name.to_string(), width, height, channels });
    }
    Ok(())
}
