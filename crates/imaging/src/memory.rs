//! How much memory may what stands in a file take? Every reader works out beforehand what it will need, and asks here.
//!
//! A few thousand bytes can describe a picture of many gigabytes. So two things bound what is taken without the user's
//! own word: what the machine has free, and the size of the file, of which [`PER_BYTE`] is more than any picture with
//! something to see in it needs.

use std::fmt;

/// Bytes in memory per byte of a file that are granted unasked. Deflate packs at most 1032 bytes into one.
pub const PER_BYTE: u64 = 1024;

/// Bytes in memory that are granted unasked for any file, however small: 2 GiB.
pub const ANY_FILE: u64 = 1 << 31;

/// The most that may be taken, and who said so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryLimit {
    bytes: u64,
    asked: bool,
}

impl Default for MemoryLimit {
    /// 16 GiB.
    fn default() -> Self {
        Self::asked(1 << 34)
    }
}

impl MemoryLimit {
    /// Whatever is needed is taken.
    pub const NONE: Self = Self { bytes: u64::MAX, asked: true };

    /// So many bytes, by the user's own word: whatever the size of the file.
    pub fn asked(bytes: u64) -> Self {
        Self { bytes, asked: true }
    }

    /// So many bytes, because that many are free, and no more than suits the size of the file.
    pub fn free(bytes: u64) -> Self {
        Self { bytes, asked: false }
    }

    /// What is left of it when `bytes` are taken.
    #[must_use]
    pub fn less(self, bytes: u64) -> Self {
        Self { bytes: self.bytes.saturating_sub(bytes), ..self }
    }

    /// The limit in bytes, whatever the file.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Whether what takes `needed` bytes may be read from a file of `file` bytes; None for what no file describes.
    ///
    /// # Errors
    /// What is needed and what there is, in words.
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

/// Why there is no more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reason {
    Asked,
    Free,
    File(u64),
}

/// More memory would be taken than there is: "takes about 4.3 GB of memory, and 2.1 GB are free; …".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrun {
    /// Bytes that are needed, about.
    pub needed: u64,
    /// Bytes that may be taken.
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

/// A number of bytes for people: "5.1 GB".
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
