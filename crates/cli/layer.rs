//! Parsing of option layers other than the command line: settings files and run specifications.

use crate::complaint;
use crate::error::Failure;
use crate::options::{self, RenderOptions};
use clap::ArgMatches;
use std::ffi::OsString;

/// Parses options without a command, as they would be typed.
pub fn parsed(arguments: &[OsString]) -> Result<ArgMatches, Failure> {
    options::command().try_get_matches_from(arguments).map_err(|e| Failure::Arguments(complaint::line(&e)))
}

impl RenderOptions {
    /// Overrides options with the given arguments.
    pub fn apply(&mut self, arguments: &[OsString]) -> Result<(), Failure> {
        self.apply_matches(&parsed(arguments)?)
    }
}
