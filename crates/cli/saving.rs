//! One failed output does not lose the others: every output is tried, what fails is told at once and saved elsewhere, and
//! the process ends with a code of its own.

use crate::say::say;
use dapple_integrator::imaging::ImageError;
use dapple_integrator::imaging::write;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code where everything was computed, but not all of it was written where it was asked for.
const NOT_WRITTEN: u8 = 4;

/// Whether something was not written where it was asked for.
static LOST: AtomicBool = AtomicBool::new(false);

/// Remembers that something was not written where it was asked for.
pub fn lose() {
    LOST.store(true, Ordering::Relaxed);
}

/// The process's exit code, which would be `code` if all was written.
pub fn code(code: ExitCode) -> ExitCode {
    if LOST.load(Ordering::Relaxed) { ExitCode::from(NOT_WRITTEN) } else { code }
}

/// Writes a file, or else saves it elsewhere; returns where it is.
pub fn save(path: &Path, write: impl Fn(&Path) -> Result<(), ImageError>) -> Option<PathBuf> {
    match write(path) {
        Ok(()) => Some(path.to_path_buf()),
        Err(error) => {
            lose();
            rescue(path, &error, write)
        }
    }
}

/// Saves elsewhere what could not be written for `error`, and says where.
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
            say(&format!("error: {error}; it is lost, for it could not be saved elsewhere ({again})"));
            None
        }
    }
}

/// Says, once, that standard output does not take what was written to it.
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
