//! Ctrl-C, and a scheduler's request to end: has somebody asked the render to stop?
//!
//! The first request ends the render within a sample and takes back what the pass under way has added, so that every pixel
//! has the same number of samples, and the pictures are written; the second one ends the process at once.

use crate::say::say;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a shell reports for a process that an interrupt ended.
const KILLED: i32 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on requests are heard. Where the system does not let us listen, the first one ends the process.
pub fn listen() {
    let heard = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(KILLED);
        }
        say("stopping, then writing what all pixels have; once more to stop at once");
    });
    if let Err(error) = heard {
        tracing::debug!(%error, "interrupts are not listened for");
    }
}

/// Whether the render is to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
