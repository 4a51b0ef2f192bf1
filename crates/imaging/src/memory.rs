//! Memory limits for reading files. Every reader computes the memory it needs in advance and checks it here.
//!
//! A few thousand bytes can describe an image of many gigabytes. Unless the user sets a limit, memory is therefore
//! limited by two quantities: the free memory of the machine, and [`PER_BYTE`] times the size of the file, which is
//! more than any image with visible content requires.

use std::fmt;

/// Bytes of memory allowed by default per byte of a file. Deflate compresses at most 1032 bytes into one.
pub const PER_BYTE: u64 = 1024;

/// Bytes of memory allowed by default for any file, however small: 2 GiB.
pub const ANY_FILE: u64 = 1 << 31;

/// Bytes of memory allowed by default per byte of a Radiance HDR file. Its run-length coding reduces images with visible
/// content to half of their four bytes per pixel at best, and reading takes 30 bytes per pixel.
pub const PER_HDR_BYTE: u64 = 64;

/// A memory limit and its origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryLimit {
    bytes: u64,
    /// Bytes of it that are in use already.
    held: u64,
    asked: bool,
}

impl Default for MemoryLimit {
    /// 16 GiB, as if set by the user.
    fn default() -> Self {
        Self::asked(1 << 34)
    }
}

impl MemoryLimit {
    /// No limit.
    pub const NONE: Self = Self { bytes: u64::MAX, held: 0, asked: true };

    /// A limit in bytes that the user has set; it applies regardless of the size of the file.
    pub fn asked(bytes: u64) -> Self {
        Self { bytes, held: 0, asked: true }
    }

    /// A limit of the given free memory in bytes; the size of the file limits it further.
    pub fn free(bytes: u64) -> Self {
        Self { bytes, held: 0, asked: false }
    }

    /// The remaining limit after `bytes` have been allocated.
    #[must_use]
    pub fn less(self, bytes: u64) -> Self {
        Self { held: self.held.saturating_add(bytes), ..self }
    }

    /// The remaining limit in bytes, regardless of the file.
    pub fn bytes(&self) -> u64 {
        self.bytes.saturating_sub(self.held)
    }

    /// Checks whether `needed` bytes of memory may be allocated for a file of `file` bytes; None if the memory does not
    /// depend on a file.
    ///
    /// # Errors
    /// The required and the allowed memory.
    pub fn admit(&self, needed: u64, file: Option<u64>) -> Result<(), Overrun> {
        self.admit_by(needed, file, PER_BYTE)
    }

    /// As [`Self::admit`], where `per_byte` bytes of memory are plausible per byte of the file.
    ///
    /// # Errors
    /// The required and the allowed memory.
    pub fn admit_by(&self, needed: u64, file: Option<u64>, per_byte: u64) -> Result<(), Overrun> {
        self.admit_from(needed, file, (per_byte, ANY_FILE))
    }

    /// As [`Self::admit_by`], where `least` bytes are plausible for any file.
    ///
    /// # Errors
    /// The required and the allowed memory.
    pub fn admit_from(
        &self,
        needed: u64,
        file: Option<u64>,
        (per_byte, least): (u64, u64),
    ) -> Result<(), Overrun> {
        let suits = file.filter(|_| !self.asked).map(|bytes| bytes.saturating_mul(per_byte).max(least));
        let limit = self.bytes().min(suits.unwrap_or(u64::MAX));
        let reason = match (self.asked, file) {
            _ if needed <= limit => return Ok(()),
            (true, _) => Reason::Asked(self.bytes),
            (false, Some(bytes)) if limit < self.bytes() => Reason::File(bytes),
            (false, _) => Reason::Free,
        };
        Err(Overrun { needed, limit, held: self.held, reason })
    }
}

/// The origin of the limit that was exceeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reason {
    /// The limit that the user has set.
    Asked(u64),
    Free,
    File(u64),
}

/// The error for exceeding a memory limit: "takes about 4.3 GB of memory, and 2.1 GB is free; …".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrun {
    /// Approximate required memory in bytes.
    pub needed: u64,
    /// Allowed memory in bytes.
    pub limit: u64,
    /// Bytes that are in use already.
    held: u64,
    reason: Reason,
}

impl fmt::Display for Overrun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (needed, limit) = (size(self.needed), size(self.limit));
        write!(f, "takes about {needed} of memory")?;
        match self.reason {
            Reason::Asked(bytes) if self.held > 0 => {
                let (held, bytes) = (size(self.held), size(bytes));
                write!(f, " in addition to {held} in use, and --memory-limit allows {bytes}")?;
            }
            Reason::Asked(bytes) => write!(f, ", and --memory-limit allows {}", size(bytes))?,
            Reason::Free => write!(f, ", and {limit} is free")?,
            Reason::File(bytes) => {
                write!(f, ", and {limit} is the most for a file of {}", size(bytes))?;
            }
        }
        let allow = self.needed.saturating_add(self.held).div_ceil(1_000_000_000);
        write!(f, "; make it smaller, or allow it with --memory-limit {allow}GB")
    }
}

/// Formats a number of bytes, as in "5.1 GB".
pub fn size(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} bytes"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_and_the_file_bound_what_is_free_and_the_users_word_alone_what_is_asked() {
        let gib = 1 << 30;
        let free = MemoryLimit::free(8 * gib);
        assert!(free.admit(8 * gib, None).is_ok() && free.admit(8 * gib + 1, None).is_err());
        assert!(free.admit(ANY_FILE, Some(1)).is_ok() && free.admit(ANY_FILE + 1, Some(1)).is_err());
        let file = 4 * gib / PER_BYTE;
        assert!(free.admit(4 * gib, Some(file)).is_ok() && free.admit(4 * gib + 1, Some(file)).is_err());
        assert!(free.admit(8 * gib + 1, Some(u64::MAX)).is_err());
        let asked = MemoryLimit::asked(8 * gib);
        assert!(asked.admit(8 * gib, Some(1)).is_ok() && asked.admit(8 * gib + 1, Some(u64::MAX)).is_err());
        assert!(MemoryLimit::NONE.admit(u64::MAX, Some(0)).is_ok());
        let (run_length, deflated) = (PER_HDR_BYTE, PER_BYTE);
        assert!(free.admit_by(4 * gib, Some(4 * gib / run_length), run_length).is_ok());
        assert!(free.admit_by(4 * gib, Some(4 * gib / deflated), run_length).is_err());
    }

    #[test]
    fn messages_hold_both_figures_and_the_remedy() {
        let say = |limit: MemoryLimit, file| limit.admit(5_100_000_000, file).unwrap_err().to_string();
        let free = say(MemoryLimit::free(2_000_000), Some(3098));
        assert_eq!(
            free,
            "takes about 5.1 GB of memory, and 2.0 MB is free; make it smaller, or allow it with --memory-limit 6GB"
        );
        assert!(
            say(MemoryLimit::free(1 << 40), Some(3098)).contains("2.1 GB is the most for a file of 3.1 kB")
        );
        assert!(say(MemoryLimit::asked(1 << 20), Some(3098)).contains("--memory-limit allows 1.0 MB"));
        let used = MemoryLimit::asked(1024).less(900_000_001);
        assert!(say(used, None).starts_with(
            "takes about 5.1 GB of memory in addition to 900.0 MB in use, and --memory-limit allows 1.0 kB"
        ));
        assert!(say(used, None).ends_with("--memory-limit 7GB"), "the whole need, rounded up");
        assert!(MemoryLimit::asked(6_000_000_001).less(900_000_001).admit(5_100_000_000, None).is_ok());
        assert_eq!([size(7), size(80_000), size(1_500_000)], ["7 bytes", "80.0 kB", "1.5 MB"]);
    }
}
