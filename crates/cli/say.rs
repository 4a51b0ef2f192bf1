//! Messages on standard error, without characters that control the terminal.

use std::borrow::Cow;
use std::io::Write;

/// Prints a line to standard error.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(line));
}

/// Replaces control characters by U+FFFD; line breaks stay. Names and paths come from files, and control characters in
/// them could move the cursor, change colours or reorder a line.
pub fn printable(text: &str) -> Cow<'_, str> {
    let acts = |c: char| (c.is_control() && c != '\n') || reorders(c);
    match text.contains(acts) {
        true => text.replace(acts, "\u{fffd}").into(),
        false => text.into(),
    }
}

/// Whether a character changes the direction of the following text (Unicode Bidirectional Algorithm, UAX #9, §2).
fn reorders(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::printable;

    #[test]
    fn nothing_acts_on_the_terminal() {
        assert_eq!(printable("Überblick – 1.5 µm\nnext"), "Überblick – 1.5 µm\nnext");
        assert_eq!(
            printable("a\u{1b}[2Jb\rc\u{9b}d\te\0"),
            "a\u{fffd}[2Jb\u{fffd}c\u{fffd}d\u{fffd}e\u{fffd}"
        );
        assert_eq!(printable("exe.\u{202e}gpj"), "exe.\u{fffd}gpj");
    }
}
