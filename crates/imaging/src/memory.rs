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

/// A memory limit and its origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryLimit {
    bytes: u64,
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
    pub const NONE: Self = Self { bytes: u64::MAX, asked: true };

    /// A limit in bytes that the user has set; it applies regardless of the size of the file.
    pub fn asked(bytes: u64) -> Self {
        Self { bytes, asked: true }
    }

    /// A limit of the given free memory in bytes; the size of the file limits it further.
    pub fn free(bytes: u64) -> Self {
        Self { bytes, asked: false }
    }

    /// The remaining limit after `bytes` have been allocated.
    #[must_use]
    pub fn less(self, bytes: u64) -> Self {
        Self { bytes: self.bytes.saturating_sub(bytes), ..self }
    }

    /// The limit in bytes, regardless of the file.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Checks whether `needed` bytes of memory may be allocated for a file of `file` bytes; None if the memory does not
    /// depend on a file.
    ///
    /// # Errors
    /// The required and the allowed memory.
    pub fn admit(&self, needed: u64, file: Option<u64>) -> Result<(), Overrun> {
        let suits = file.filter(|_| !self.asked).map(|bytes| bytes.saturating_mul(PER_BYTE).max(ANY_FILE));
        let limit = self.bytes.min(suits.unwrap_or(u64::MAX));
        let reason = match (self.asked, file) {
            _ if needed <= limit => return Ok(()),
            (true, _) => Reason::Asked,
            (false, Some(bytes)) if limit < self.bytes => Reason::File(bytes),
            (false, _) => Reason::Free,
        };
        Err(Overrun { needed, limit, reason })
    }
}

/// The origin of the limit that was exceeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reason {
    Asked,
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
    reason: Reason,
}

impl fmt::Display for Overrun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (needed, limit) = (size(self.needed), size(self.limit));
        write!(f, "takes about {needed} of memory, and ")?;
        match self.reason {
            Reason::Asked => write!(f, "--memory-limit allows {limit}")?,
            Reason::Free => write!(f, "{limit} is free")?,
            Reason::File(bytes) => write!(f, "{limit} is the most for a file of {}", size(bytes))?,
        }
        let allow = self.needed.div_ceil(1 << 30);
        write!(f, "; make it smaller, or allow it with --memory-limit {allow}G")
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
    }

    #[test]
    fn messages_hold_both_figures_and_the_remedy() {
        let say = |limit: MemoryLimit, file| limit.admit(5_100_000_000, file).unwrap_err().to_string();
        let free = say(MemoryLimit::free(2_000_000), Some(3098));
        assert_eq!(
            free,
            "takes about 5.1 GB of memory, and 2.0 MB is free; make it smaller, or allow it with --memory-limit 5G"
        );
        assert!(
            say(MemoryLimit::free(1 << 40), Some(3098)).contains("2.1 GB is the most for a file of 3.1 kB")
        );
        assert!(say(MemoryLimit::asked(1 << 20), Some(3098)).contains("--memory-limit allows 1.0 MB"));
        assert_eq!([size(7), size(80_000), size(1_500_000)], ["7 bytes", "80.0 kB", "1.5 MB"]);
    }
}
