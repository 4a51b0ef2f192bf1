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

/// Whether the render should stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
