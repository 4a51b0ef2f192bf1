//! Errors of the commands, each with a one-line message, and their exit codes.

use dapple_integrator::imaging::{ImageError, Window};
use dapple_integrator::scene::SceneError;
use dapple_integrator::scene::error::shortened;
use std::path::PathBuf;
use std::process::ExitCode;

/// An error that ends a command.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// An invalid command line, with the complete message.
    #[error("{0}")]
    Arguments(String),
    /// A scene that cannot be read or built.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// An image that cannot be read or written.
    #[error("{0}")]
    Image(#[from] ImageError),
    /// A settings file that cannot be read.
    #[error("{path}: {reason}", path = .path.display())]
    SettingsFile { path: PathBuf, reason: String },
    /// A key of a settings file that is unknown or has a wrong value.
    #[error("{path}: key '{key}': {reason}", path = .path.display())]
    SettingsKey { path: PathBuf, key: String, reason: String },
    /// Images that cannot be compared.
    #[cfg(feature = "report")]
    #[error("{0}")]
    Size(#[from] dapple_analysis::metrics::SizeMismatch),
    /// Crops of one image that have no pixel in common.
    #[error(
        "{}, {}: have no pixel in common: one covers {}, the other {}; render the same --crop",
        .image.display(), .other.display(), .windows[0], .windows[1]
    )]
    NoOverlap { image: PathBuf, other: PathBuf, windows: Box<[Window; 2]> },
    /// A check that was requested and failed.
    #[error("{0}")]
    Check(String),
    /// An environment map with a value that is not a valid radiance.
    #[error("{path}: {reason}", path = .path.display())]
    Environment { path: PathBuf, reason: String },
}

impl Failure {
    /// Returns the exit code: 1 for failed checks, 2 for bad input and bad arguments (3 is for renders that were
    /// stopped early, 4 for outputs that were not all written).
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(if matches!(self, Self::Check(_)) { 1 } else { 2 })
    }
}

/// Joins the lines of a message into one, and shortens long values that it quotes.
pub fn one_line(message: &str) -> String {
    let message = shortened(message);
    message.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ")
}

/// Shortens a value for quoting in messages.
pub use dapple_integrator::scene::error::quoted as short;

/// Returns the part of clap's message that says what is wrong, without the usage that follows it.
pub fn clap_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let said = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
        .filter(|line| !line.is_empty())
        .collect::<Vec<_>>()
        .join("; ");
    said.strip_prefix("error: ").unwrap_or(&said).to_string()
}
