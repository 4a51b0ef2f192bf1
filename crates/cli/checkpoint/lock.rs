//! Lock of a checkpoint file, so that two processes do not replace each other's.
//!
//! The checkpoint itself is replaced by renaming, so that its lock would be lost; a file `NAME.lock` beside it is locked
//! instead. The system releases the lock when the process ends in any way.

use crate::error::Failure;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

/// A held lock; its file is removed at the end.
pub struct Lock {
    file: File,
    path: PathBuf,
}

impl Lock {
    /// Locks the checkpoint at `path`.
    ///
    /// # Errors
    /// If another process holds the lock, or no lock file can be created.
    pub fn take(path: &Path) -> Result<Self, Failure> {
        let mut name = path.file_name().unwrap_or_default().to_os_string();
        name.push(".lock");
        let lock = path.with_file_name(name);
        let failed =
            |e| Failure::Arguments(format!("--checkpoint {}: cannot be locked: {e}", path.display()));
        loop {
            let file =
                OpenOptions::new().create(true).truncate(false).write(true).open(&lock).map_err(failed)?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => {
                    return Err(Failure::Arguments(format!(
                        "--checkpoint {}: another process renders with this checkpoint; wait for it, or choose another \
                         file",
                        path.display()
                    )));
                }
                // Where locks are not supported, two processes are not told apart.
                Ok(()) | Err(TryLockError::Error(_)) => {}
            }
            // The former holder may have removed the file since it was opened.
            if same_file::Handle::from_path(&lock).ok()
                == file.try_clone().and_then(same_file::Handle::from_file).ok()
            {
                return Ok(Self { file, path: lock });
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
        let _ = self.file.unlock();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.checkpoint");
        let first = Lock::take(&path).unwrap();
        let said = Lock::take(&path).err().unwrap().to_string();
        assert!(said.contains("another process") && said.contains("a.checkpoint"), "{said}");
        assert!(Lock::take(&folder.path().join("b.checkpoint")).is_ok());
        drop(first);
        assert!(Lock::take(&path).is_ok());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
