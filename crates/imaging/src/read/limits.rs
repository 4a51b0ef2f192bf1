//! How large may a picture be, and how much memory may reading it take?

use crate::{ImageError, MemoryLimit};

/// Pixels that a picture may have, 2²⁸ = 16384²: larger ones are refused before memory is taken.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Numbers (pixels times channels) that an EXR may take in memory: 2³⁰, 4 GiB.
pub const MAX_SAMPLES: u64 = 1 << 30;

/// What one file may take.
#[derive(Clone, Copy, Debug)]
#[allow(dead_code, reason = "unused without any decoder")]
pub(super) struct Room {
    pub limit: MemoryLimit,
    /// Bytes of the file.
    pub file: u64,
}

#[allow(dead_code, reason = "unused without any decoder")]
impl Room {
    /// Whether so many pixels of so many bytes each, and `more` bytes, may be held.
    pub fn admit(
        &self,
        name: &str,
        [width, height]: [u64; 2],
        each: u64,
        more: u64,
    ) -> Result<(), ImageError> {
        let needed = width.saturating_mul(height).saturating_mul(each).saturating_add(more);
        let refuse = |overrun| ImageError::Memory { name: name.to_string(), width, height, overrun };
        self.limit.admit(needed, Some(self.file)).map_err(refuse)
    }
}

/// Whether a picture of this size is within the limits.
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
