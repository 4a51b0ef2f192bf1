//! Ctrl-C, and a scheduler's request to end: has somebody asked the render to stop?
//!
//! The first request lets the pass under way finish, so that every pixel has the same number of samples, and the
//! pictures are written; the second one ends the process at once.

use crate::report;
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
        report::say("stopping after this pass, then writing; once more to stop at once");
    });
    if let Err(error) = heard {
        tracing::debug!(%error, "interrupts are not listened for");
    }
}

/// Whether the render is to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
