//! State shared by the parts of a comparison: arguments, clock, folder and the results so far.

use super::folder::Folder;
use crate::args::study::ConvergeArgs;
use crate::error::Failure;
use crate::load::Source;
use crate::options::RenderOptions;
use crate::progress::Bar;
use crate::{memory, settings_file};
use clap::ArgMatches;
use dapple_analysis::converge::{Clock, Reference};
use dapple_analysis::results::{ReferenceRecord, Results};

/// State shared by the parts of the command.
pub struct Session<'a> {
    pub arguments: &'a ConvergeArgs,
    pub clock: Clock,
    pub folder: Folder,
    pub results: Results,
    pub bar: Bar,
    /// Memory limit set by the user, for the current scene.
    pub memory_limit: Option<u64>,
}

impl Session<'_> {
    /// Reads a reference from the folder.
    pub fn kept(&self, record: &ReferenceRecord) -> Option<Reference> {
        self.folder.reference(record, memory::limit(self.memory_limit))
    }

    /// Returns the first seed of the runs; the command checks its range.
    pub fn first_seed(&self) -> u32 {
        self.arguments.options.seed.map_or(1, |seed| seed as u32)
    }

    /// Adds a reference for the run `user`. Only the first of a scene is named "reference".
    pub fn add_reference(&mut self, mut record: ReferenceRecord, user: &str) {
        let is_first = self.results.references.iter().all(|r| r.scene != record.scene);
        record.name = if is_first { "reference".into() } else { format!("reference of {user}") };
        self.results.references.push(record);
    }
}

/// A scene with its options.
pub struct Given<'a> {
    pub name: &'a str,
    pub source: Source,
    pub options: RenderOptions,
}

impl<'a> Given<'a> {
    pub fn new(name: &'a str, typed: &ArgMatches) -> Result<Self, Failure> {
        let source = Source::new(Some(name));
        let options = settings_file::layered(source.path(), typed, "converge")?;
        Ok(Self { name, source, options })
    }
}
