//! Saving of outputs such that one failure does not lose the others: every output is tried, failures are reported at
//! once and saved elsewhere, and the process ends with a separate exit code.

use crate::say::say;
use dapple_integrator::imaging::ImageError;
use dapple_integrator::imaging::write;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code when everything was rendered but not every output was written where it was requested.
const NOT_WRITTEN: u8 = 4;

/// Whether an output was not written where it was requested.
static LOST: AtomicBool = AtomicBool::new(false);

/// Records that an output was not written where it was requested.
pub fn lose() {
    LOST.store(true, Ordering::Relaxed);
}

/// Returns the exit code of the process: `code` if everything was written.
pub fn code(code: ExitCode) -> ExitCode {
    if LOST.load(Ordering::Relaxed) { ExitCode::from(NOT_WRITTEN) } else { code }
}

/// Writes a file, or else saves it elsewhere; returns the path of the written file.
pub fn save(path: &Path, write: impl Fn(&Path) -> Result<(), ImageError>) -> Option<PathBuf> {
    match write(path) {
        Ok(()) => Some(path.to_path_buf()),
        Err(error) => {
            lose();
            rescue(path, &error, write)
        }
    }
}

/// Saves an output elsewhere after it failed with `error`, and prints where.
pub fn rescue(
    path: &Path,
    error: &ImageError,
    write: impl Fn(&Path) -> Result<(), ImageError>,
) -> Option<PathBuf> {
    match write::elsewhere(path, write) {
        Ok(at) => {
            say(&format!("error: {error}; it is saved as {}", at.display()));
            Some(at)
        }
        Err(again) => {
            say(&format!("error: {error}; it is lost, because it could not be saved elsewhere ({again})"));
            None
        }
    }
}

/// Prints, once, that standard output cannot be written.
pub fn lose_standard_output(error: &io::Error) {
    static TOLD: AtomicBool = AtomicBool::new(false);
    lose();
    if !TOLD.swap(true, Ordering::Relaxed) {
        let why = match error.kind() {
            io::ErrorKind::BrokenPipe => "its reader has closed it".into(),
            _ => error.to_string(),
        };
        say(&format!("error: standard output: cannot be written: {why}"));
    }
}
