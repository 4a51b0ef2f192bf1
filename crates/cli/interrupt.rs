//! Signals: requests to stop, from Ctrl-C or a scheduler, and requests to save.
//!
//! The first SIGINT (Ctrl-C) or SIGTERM ends the render within a sample and discards the unfinished pass, so that every
//! pixel has the same number of samples, and the images are written. A second SIGINT ends the process at once; further
//! SIGTERM are ignored, because schedulers repeat them. SIGUSR1 saves the image so far, and the render continues.

use crate::say::say;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code that shells report for a process ended by an interrupt.
const KILLED: i32 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);
static SAVE: AtomicBool = AtomicBool::new(false);

/// Starts listening for signals. If the system does not allow it, the first request ends the process.
#[cfg(unix)]
pub fn listen() {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
    let listen = |mut signals: signal_hook::iterator::Signals| {
        for signal in signals.forever() {
            match signal {
                SIGUSR1 => SAVE.store(true, Ordering::Relaxed),
                signal => stop(signal == SIGINT),
            }
        }
    };
    let started = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGUSR1]).and_then(|signals| {
        std::thread::Builder::new().name("signals".into()).spawn(move || listen(signals))
    });
    if let Err(error) = started {
        tracing::debug!(%error, "cannot listen for signals");
    }
}

/// Starts listening for interrupts. If the system does not allow it, the first one ends the process.
#[cfg(not(unix))]
pub fn listen() {
    if let Err(error) = ctrlc::set_handler(|| stop(true)) {
        tracing::debug!(%error, "cannot listen for interrupts");
    }
}

/// Requests an end; if `is_interrupt`, a repeated request ends the process.
fn stop(is_interrupt: bool) {
    if !ASKED.swap(true, Ordering::Relaxed) {
        say("stopping; the completed passes are written; interrupt again to quit at once");
    } else if is_interrupt {
        std::process::exit(KILLED);
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

/// Whether the image so far should be saved; forgets the request.
pub fn take_save() -> bool {
    SAVE.swap(false, Ordering::Relaxed)
}
