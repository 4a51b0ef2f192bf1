//! Checks before the first ray: disk space for everything that a render writes. `--dry-run` prints the forecast.

mod disk;

use crate::checkpoint;
use crate::error::Failure;
use crate::load;
use crate::options::RenderOptions;
use crate::output::Outputs;
use dapple_integrator::Settings;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Bytes of a file beside its pixels: header and metadata.
const HEADER: u64 = 1 << 16;

/// A file that a render writes.
#[derive(Debug, Serialize)]
pub struct Planned {
    pub path: PathBuf,
    /// Upper bound of its size in bytes, without compression. A file that is replaced exists twice for a moment.
    pub bytes_at_most: u64,
}

/// Space on one file system.
#[derive(Debug, Serialize)]
pub struct Space {
    /// A folder on it to which the render writes.
    pub folder: PathBuf,
    /// Upper bound of the bytes that are written.
    pub needed_bytes: u64,
    /// Bytes that are free; null if the system does not tell.
    pub free_bytes: Option<u64>,
}

impl Space {
    /// Whether the files may not fit.
    pub fn is_short(&self) -> bool {
        self.free_bytes.is_some_and(|free| free < self.needed_bytes)
    }
}

/// Returns the files that a render of `images` images writes, with bounds of their sizes.
pub fn planned(
    outputs: &Outputs,
    files: &checkpoint::Files,
    options: &RenderOptions,
    settings: &Settings,
    images: u64,
) -> Vec<Planned> {
    let pixels = settings.rect().area() as u64;
    let state = HEADER + pixels * load::pixel_bytes(options);
    let size = |path: &Path| match outputs.bytes_per_pixel(path, options) {
        Some(bytes) => HEADER + pixels * bytes,
        None => state,
    };
    let one = |path: &Path, copies: u64| Planned {
        path: path.to_path_buf(),
        bytes_at_most: copies.saturating_mul(size(path)),
    };
    // An image so far, or the former checkpoint, exists beside the new file.
    let images = outputs.paths().map(|path| one(path, images.saturating_add(1)));
    let checkpoints =
        files.paths().map(|path| Planned { path: path.to_path_buf(), bytes_at_most: 2 * state });
    images.chain(checkpoints).collect()
}

/// Returns the space on every file system that the files are on.
pub fn spaces(planned: &[Planned]) -> Vec<Space> {
    let mut all: BTreeMap<u64, Space> = BTreeMap::new();
    for file in planned {
        let folder = match file.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
            _ => PathBuf::from("."),
        };
        let space = all.entry(disk::device(&folder)).or_insert_with(|| Space {
            needed_bytes: 0,
            free_bytes: disk::free_bytes(&folder),
            folder,
        });
        space.needed_bytes = space.needed_bytes.saturating_add(file.bytes_at_most);
    }
    all.into_values().collect()
}

/// Refuses a render whose files may not fit on a disk, unless `--yes` is given.
pub fn check(planned: &[Planned], options: &RenderOptions) -> Result<(), Failure> {
    let short = spaces(planned).into_iter().find(Space::is_short);
    match short.filter(|_| !RenderOptions::is(options.effects.yes)) {
        None => Ok(()),
        Some(space) => Err(Failure::Arguments(format!(
            "{}: the files of this render take up to {}, and {} are free; free some space, write elsewhere, or go on \
             with --yes",
            space.folder.display(),
            megabytes(space.needed_bytes),
            megabytes(space.free_bytes.unwrap_or_default())
        ))),
    }
}

/// Formats a number of bytes.
pub fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_do_not_fit_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = |bytes_at_most| [Planned { path: folder.path().join("a.exr"), bytes_at_most }];
        let mut options = RenderOptions::default();
        assert!(check(&file(1), &options).is_ok());
        if disk::free_bytes(folder.path()).is_some() {
            let said = check(&file(u64::MAX), &options).unwrap_err().to_string();
            assert!(said.contains("are free; free some space"), "{said}");
        }
        options.effects.yes = Some(true);
        assert!(check(&file(u64::MAX), &options).is_ok());
    }
}
