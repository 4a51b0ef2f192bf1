//! What can be wrong with a scene. Every message is one line that names the file (or the scene built in code), the
//! thing in it, and what to do.
use std::path::PathBuf;

/// Why there is no scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file, or a file it refers to, cannot be read.
    #[error("{}: cannot read {what}: {source}", file.display())]
    Io {
        /// The scene's file.
        file: PathBuf,
        /// What was being read.
        what: String,
        /// The system's answer.
        source: std::io::Error,
    },
    /// Not glTF, or cut short.
    #[error("{}: not a readable glTF 2.0 file: {what}", file.display())]
    Malformed {
        /// The scene's file.
        file: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// Something in the file contradicts itself or the format.
    #[error("{file}: {place}: {what}")]
    Invalid {
        /// File or scene name.
        file: String,
        /// The thing that is wrong, by kind, index and name.
        place: String,
        /// What is wrong with it.
        what: String,
    },
    /// The file cannot be shown as meant without an extension that dapple does not have.
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
    /// A scene, variant or animation that was asked for and is not there.
    #[error(
        "{}: --{kind} {}: there is no such {kind}; the file has {}",
        file.display(),
        quoted(wanted),
        if there.is_empty() { "none" } else { there }
    )]
    Choice {
        /// The scene's file.
        file: PathBuf,
        /// What was to be chosen: "scene", "variant" or "animation".
        kind: String,
        /// The name or index asked for.
        wanted: String,
        /// What there is, with index and name; empty if there is nothing.
        there: String,
    },
    /// A reference that leaves the scene's folder.
    #[error("{}: {place} refers to '{}': {what}", file.display(), quoted(uri))]
    Path {
        /// The scene's file.
        file: PathBuf,
        /// What refers.
        place: String,
        /// Where to.
        uri: String,
        /// Why not.
        what: String,
    },
    /// More memory than there is, or than suits the size of the file.
    #[error("{}: {place} {overrun}", file.display())]
    Memory {
        /// The scene's file.
        file: PathBuf,
        /// What takes it.
        place: String,
        /// What is needed and what there is.
        overrun: dapple_imaging::memory::Overrun,
    },
    /// A texture that cannot be decoded.
    #[error("{}: {source}", file.display())]
    Image {
        /// The scene's file.
        file: PathBuf,
        /// The decoder's answer, which names the image.
        source: dapple_imaging::ImageError,
    },
}

impl SceneError {
    pub(crate) fn invalid(file: &str, place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Invalid { file: file.to_owned(), place: place.into(), what: what.into() }
    }
}

/// Most characters of a value that a message repeats.
pub const MOST: usize = 80;

/// A value of the file as messages quote it: its first 80 characters, without control characters.
pub fn quoted(value: &str) -> String {
    let mut shown: String =
        value.chars().take(16 * MOST).filter(|c| !c.is_control()).take(MOST + 1).collect();
    if let Some((end, _)) = shown.char_indices().nth(MOST) {
        shown.truncate(end);
        shown.push('…');
    }
    shown
}

/// A message with each value that it quotes, in '…', "…" or `…`, cut as by [`quoted`]: for the words of other libraries,
/// which repeat values whole.
pub fn shortened(message: &str) -> String {
    let (mut shown, mut rest) = (String::new(), message);
    while let Some((start, mark)) = opening(rest, shown.chars().next_back()) {
        let (before, inner) = rest.split_at(start + 1);
        shown.push_str(before);
        rest = inner;
        if let Some(end) = closing(inner, mark) {
            let (value, after) = inner.split_at(end);
            shown.push_str(&if value.chars().count() > MOST { quoted(value) } else { value.into() });
            // The closing mark goes with the value: it opens nothing.
            shown.push(mark);
            rest = &after[1..];
        }
    }
    shown + rest
}

/// The first mark that opens a quotation. An apostrophe after a letter or digit opens none.
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

/// Where the quotation ends: at the mark that opened it, unless a backslash stands before it or, for an apostrophe, a
/// letter or digit behind it.
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

/// Something that will look different from what the file says; rendering goes on.
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
