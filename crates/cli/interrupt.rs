//! Interrupts: Ctrl-C and termination requests of a scheduler stop the render.
//!
//! The first request ends the render within a sample and discards the unfinished pass, so that every pixel has the same
//! number of samples, and the images are written; the second one ends the process at once.

use crate::say::say;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code that shells report for a process ended by an interrupt.
const KILLED: i32 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);

/// Starts listening for requests. If the system does not allow a handler, the first request ends the process.
pub fn listen() {
    let heard = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(KILLED);
        }
        say("stopping; the completed passes are written; interrupt again to quit at once");
    });
    if let Err(error) = heard {
        tracing::debug!(%error, "cannot listen for interrupts");
    }
}

/// Lets a write beyond the limit of file sizes (`ulimit -f`) fail with an error, like any other write, instead of ending
/// the process with SIGXFSZ, which would lose the other outputs.
#[cfg(unix)]
pub fn survive_file_limit() {
    let seen = std::sync::Arc::new(AtomicBool::new(false));
    if let Err(error) = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, seen) {
        tracing::debug!(%error, "the limit of file sizes ends the process");
    }
}

/// Systems other than Unix have no such limit.
#[cfg(not(unix))]
pub fn survive_file_limit() {}

/// Whether the render should stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
