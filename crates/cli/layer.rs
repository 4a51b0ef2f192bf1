//! Options as they would be typed, parsed by themselves and laid over others: what settings files and plans of runs say.

use crate::complaint;
use crate::error::Failure;
use crate::options::{self, RenderOptions};
use clap::ArgMatches;
use std::ffi::OsString;

/// Options alone, as they would be typed.
pub fn parsed(arguments: &[OsString]) -> Result<ArgMatches, Failure> {
    options::command().try_get_matches_from(arguments).map_err(|e| Failure::Arguments(complaint::line(&e)))
}

impl RenderOptions {
    /// Lays the given arguments over what is there.
    pub fn apply(&mut self, arguments: &[OsString]) -> Result<(), Failure> {
        self.lay_matches(&parsed(arguments)?)
    }
}
