//! Errors and warnings about scenes. Every message is one line that names the file (or the scene built in code), the
//! object in it, and the remedy.
use std::path::PathBuf;

/// The reason why a scene cannot be read or built.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file, or a file it refers to, cannot be read.
    #[error("{}: cannot read {what}: {source}", file.display())]
    Io {
        /// The scene's file.
        file: PathBuf,
        /// The item that was being read.
        what: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is not glTF, or it is truncated.
    #[error("{}: not a readable glTF 2.0 file: {what}", file.display())]
    Malformed {
        /// The scene's file.
        file: PathBuf,
        /// The problem.
        what: String,
    },
    /// Something in the file is inconsistent or violates the format.
    #[error("{file}: {place}: {what}")]
    Invalid {
        /// Name of the file or the scene.
        file: String,
        /// The object at fault, by kind, index and name.
        place: String,
        /// The problem with it.
        what: String,
    },
    /// The file requires an extension that dapple does not support.
    #[error(
        "{}: needs the glTF extension {}, which dapple does not support; export the scene without it",
        file.display(),
        quoted(extension)
    )]
    Extension {
        /// The scene's file.
        file: PathBuf,
        /// The extension's name.
        extension: String,
    },
    /// The requested scene, variant or animation does not exist.
    #[error(
        "{}: --{kind} {}: there is no such {kind}; the file has {}",
        file.display(),
        quoted(wanted),
        if there.is_empty() { "none" } else { there }
    )]
    Choice {
        /// The scene's file.
        file: PathBuf,
        /// The kind of item that was requested: "scene", "variant" or "animation".
        kind: String,
        /// The requested name or index.
        wanted: String,
        /// The items that exist, with index and name; empty if there are none.
        there: String,
    },
    /// A reference leads out of the scene's folder.
    #[error("{}: {place} refers to '{}': {what}", file.display(), quoted(uri))]
    Path {
        /// The scene's file.
        file: PathBuf,
        /// The object that contains the reference.
        place: String,
        /// The target of the reference.
        uri: String,
        /// The reason why it is not followed.
        what: String,
    },
    /// The scene needs more memory than is available, or than is plausible for the size of the file.
    #[error("{}: {place} {overrun}", file.display())]
    Memory {
        /// The scene's file.
        file: PathBuf,
        /// The object that needs the memory.
        place: String,
        /// The required and the available memory.
        overrun: dapple_imaging::memory::Overrun,
    },
    /// A texture cannot be decoded.
    #[error("{}: {source}", file.display())]
    Image {
        /// The scene's file.
        file: PathBuf,
        /// The error of the decoder, which names the image.
        source: dapple_imaging::ImageError,
    },
}

impl SceneError {
    pub(crate) fn invalid(file: &str, place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Invalid { file: file.to_owned(), place: place.into(), what: what.into() }
    }
}

/// Maximum number of characters of a value that a message quotes.
pub const MOST: usize = 80;

/// Whether a character controls a terminal, breaks a line, or changes the direction of the following text (Unicode
/// Bidirectional Algorithm, UAX #9, §2).
pub fn is_control(c: char) -> bool {
    let breaks = matches!(c, '\u{2028}' | '\u{2029}');
    let reorders =
        matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || breaks || reorders
}

/// Formats a value of the file for a message: its first 80 characters, without control characters.
pub fn quoted(value: &str) -> String {
    let mut shown: String =
        value.chars().take(16 * MOST).filter(|c| !is_control(*c)).take(MOST + 1).collect();
    if let Some((end, _)) = shown.char_indices().nth(MOST) {
        shown.truncate(end);
        shown.push('…');
    }
    shown
}

/// Truncates each value that a message quotes in '…', "…" or `…` as [`quoted`] does. Used for messages of other
/// libraries, which quote values in full.
pub fn shortened(message: &str) -> String {
    let (mut shown, mut rest) = (String::new(), message);
    while let Some((start, mark)) = opening(rest, shown.chars().next_back()) {
        let (before, inner) = rest.split_at(start + 1);
        shown.push_str(before);
        rest = inner;
        if let Some(end) = closing(inner, mark) {
            let (value, after) = inner.split_at(end);
            shown.push_str(&if value.chars().count() > MOST { quoted(value) } else { value.into() });
            // The closing mark belongs to the value and does not open another quotation.
            shown.push(mark);
            rest = &after[1..];
        }
    }
    shown + rest
}

/// The first mark that opens a quotation. An apostrophe after a letter or digit does not.
fn opening(text: &str, mut before: Option<char>) -> Option<(usize, char)> {
    for (at, c) in text.char_indices() {
        let in_word = before.is_some_and(char::is_alphanumeric);
        if matches!(c, '"' | '`') || (c == '\'' && !in_word) {
            return Some((at, c));
        }
        before = Some(c);
    }
    None
}

/// Position at which the quotation ends: the next occurrence of its opening mark that is not preceded by a backslash
/// and, for an apostrophe, not followed by a letter or digit.
fn closing(text: &str, mark: char) -> Option<usize> {
    let mut escaped = false;
    for (at, c) in text.char_indices() {
        let in_word = || mark == '\'' && text[at + 1..].starts_with(char::is_alphanumeric);
        if c == mark && !escaped && !in_word() {
            return Some(at);
        }
        escaped = c == '\\' && !escaped;
    }
    None
}

/// A difference between the file and what is rendered; rendering continues.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning(pub String);

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{quoted, shortened};

    #[test]
    fn long_values_are_cut_between_characters() {
        assert_eq!(quoted("a\u{1b}[2J b"), "a[2J b");
        assert_eq!(quoted("a\u{2028}b\u{2029}c\u{202e}d\ne"), "abcde");
        assert_eq!(quoted(&"ü".repeat(80)), "ü".repeat(80));
        assert_eq!(quoted(&"ü".repeat(81)), format!("{}…", "ü".repeat(80)));
    }

    #[test]
    fn what_others_quote_is_cut() {
        let long = "ü\\\"".repeat(100);
        let cut = quoted(&long);
        for (message, shown) in [
            (
                format!("invalid type: string \"{long}\", expected f32"),
                format!("invalid type: string \"{cut}\", expected f32"),
            ),
            (
                "the scene's own 'name', \"it's\" and `x`".into(),
                "the scene's own 'name', \"it's\" and `x`".into(),
            ),
            (
                format!("it isn't '{}' or `b`", "a".repeat(81)),
                format!("it isn't '{}…' or `b`", "a".repeat(80)),
            ),
            (format!("an open \" and {}", "x ".repeat(99)), format!("an open \" and {}", "x ".repeat(99))),
            (String::new(), String::new()),
        ] {
            assert_eq!(shortened(&message), shown);
        }
    }
}
