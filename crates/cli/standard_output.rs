//! Standard output: output that cannot be written is reported as an error with its own exit code (4).

use crate::saving;
use crate::say::{printable, say};
use serde::Serialize;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the process was started without a standard output. The standard library then opens `/dev/null` in its place
/// before `main` runs, where all output is lost without an error.
static CLOSED: AtomicBool = AtomicBool::new(false);

/// Writes all bytes; the first failure is reported.
pub fn write(bytes: &[u8]) {
    print(|| io::stdout().write_all(bytes));
}

/// Writes to standard output with the given function; see [`write()`].
pub fn print(print: impl FnOnce() -> io::Result<()>) {
    let printed = match CLOSED.load(Ordering::Relaxed) {
        true => Err(io::Error::other("it is closed")),
        false => print().and_then(|()| io::stdout().flush()),
    };
    if let Err(error) = printed {
        saving::lose_standard_output(&error);
    }
}

/// Prints a line to standard output.
pub fn result(line: &str) {
    write(format!("{}\n", printable(line)).as_bytes());
}

/// Prints a text of several lines to standard output.
pub fn results(text: &str) {
    text.lines().for_each(result);
}

/// Prints one JSON object on a line of its own.
pub fn json(value: &impl Serialize) {
    match serde_json::to_string(value) {
        Ok(line) => result(&line),
        Err(e) => say(&format!("error: the result cannot be written as JSON: {e}")),
    }
}

/// Checks the descriptor before the standard library replaces it.
#[cfg(any(target_os = "linux", target_os = "macos"))]
mod at_start {
    use std::os::fd::AsFd;
    use std::sync::atomic::Ordering;

    extern "C" fn look() {
        // Duplicating needs an open descriptor and writes nothing.
        let open = std::io::stdout().as_fd().try_clone_to_owned().is_ok();
        crate::standard_output::CLOSED.store(!open, Ordering::Relaxed);
    }

    /// Function that the loader calls before `main`, once and while no other thread exists.
    // Safety: the section holds pointers to functions that take the loader's arguments and return nothing; `look`
    // ignores its arguments, does not unwind, and uses nothing of the standard library that `main` has to set up.
    #[allow(unsafe_code, reason = "functions that run before main require a link section")]
    #[used]
    #[cfg_attr(target_os = "linux", unsafe(link_section = ".init_array"))]
    #[cfg_attr(target_os = "macos", unsafe(link_section = "__DATA,__mod_init_func"))]
    static LOOK: extern "C" fn() = look;
}
