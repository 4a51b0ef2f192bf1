//! Whole files or none: a temporary file in the target's folder, renamed over the target.

use crate::ImageError;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Puts `bytes` in place of whatever was at `path`: all of them, or on failure none, and the old file stays.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    let target = target(path)?;
    let failed = |source| ImageError::Write { path: path.to_path_buf(), source };
    let mut file = beside(&target).map_err(failed)?;
    file.write_all(bytes).map_err(failed)?;
    // Without this a crash of the machine may keep the new name and lose the bytes.
    file.as_file().sync_all().map_err(failed)?;
    file.persist(&target).map(drop).map_err(|e| failed(e.error))
}

/// Tries to create a file beside `path`, and takes it away again.
pub(super) fn probe(path: &Path) -> Result<(), ImageError> {
    let file =
        beside(&target(path)?).map_err(|source| ImageError::Write { path: path.to_path_buf(), source })?;
    file.close().map_err(|source| ImageError::Write { path: path.to_path_buf(), source })
}

/// The file to replace: the end of a symbolic link, so that the link itself survives. Only plain files are
/// replaced, for renaming over a device such as /dev/null would remove it.
fn target(path: &Path) -> Result<PathBuf, ImageError> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    match fs::metadata(&target) {
        Ok(at) if !at.is_file() => Err(ImageError::NotAFile { name: path.display().to_string() }),
        _ if folder(&target).is_dir() => Ok(target),
        _ => Err(ImageError::NoFolder { path: path.to_path_buf(), folder: folder(&target).to_path_buf() }),
    }
}

fn folder(target: &Path) -> &Path {
    target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn beside(target: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".dapple-").suffix(".part");
    // tempfile's own default is 0600: a picture is nobody's secret, the user's umask decides.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder(target))
}
