//! Free space of file systems.

use std::path::Path;

/// Returns the bytes that this user may still write to the file system of a folder; none if that is unknown, as for
/// file systems that keep nothing.
#[cfg(unix)]
pub fn free_bytes(folder: &Path) -> Option<u64> {
    let found = rustix::fs::statvfs(folder).ok().filter(|found| found.f_blocks > 0)?;
    found.f_bavail.checked_mul(found.f_frsize)
}

/// Identifies the file system of a folder.
#[cfg(unix)]
pub fn device(folder: &Path) -> u64 {
    use std::os::unix::fs::MetadataExt;
    folder.metadata().map_or(0, |folder| folder.dev())
}

/// Returns none, because the standard library does not tell.
#[cfg(not(unix))]
pub fn free_bytes(_: &Path) -> Option<u64> {
    None
}

/// Takes all folders for one file system.
#[cfg(not(unix))]
pub fn device(_: &Path) -> u64 {
    0
}
