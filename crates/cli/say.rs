//! Messages on standard error, without characters that control the terminal.

use dapple_integrator::scene::error::is_control;
use std::borrow::Cow;
use std::io::Write;

/// Prints a line to standard error.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(line));
}

/// Prints a text of several lines to standard error.
pub fn say_lines(text: &str) {
    text.lines().for_each(say);
}

/// Replaces control characters and line breaks by U+FFFD. Names and paths come from files, and control characters in
/// them could move the cursor, change colours, reorder a line or forge a message.
pub fn printable(line: &str) -> Cow<'_, str> {
    match line.contains(is_control) {
        true => line.replace(is_control, "\u{fffd}").into(),
        false => line.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::printable;

    #[test]
    fn nothing_acts_on_the_terminal() {
        assert_eq!(printable("Überblick – 1.5 µm"), "Überblick – 1.5 µm");
        assert_eq!(printable("a\nwarning: b\u{2028}c\u{2029}d"), "a\u{fffd}warning: b\u{fffd}c\u{fffd}d");
        assert_eq!(
            printable("a\u{1b}[2Jb\rc\u{9b}d\te\0"),
            "a\u{fffd}[2Jb\u{fffd}c\u{fffd}d\u{fffd}e\u{fffd}"
        );
        assert_eq!(printable("exe.\u{202e}gpj"), "exe.\u{fffd}gpj");
    }
}
