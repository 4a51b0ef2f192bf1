//! What the parts of a comparison share: arguments, clock, folder and the results so far.

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

/// Everything that the parts of the command share.
pub struct Session<'a> {
    pub arguments: &'a ConvergeArgs,
    pub clock: Clock,
    pub folder: Folder,
    pub results: Results,
    pub bar: Bar,
    /// What the user said of memory, for the scene that is measured.
    pub memory_limit: Option<u64>,
}

impl Session<'_> {
    /// A reference that lies in the folder.
    pub fn kept(&self, record: &ReferenceRecord) -> Option<Reference> {
        self.folder.reference(record, memory::limit(self.memory_limit))
    }

    /// The first seed of runs; the command checks that it is no larger.
    pub fn first_seed(&self) -> u32 {
        self.arguments.options.seed.map_or(1, |seed| seed as u32)
    }

    /// Adds a reference of the run `user`. The first of a scene is called "reference", and no other.
    pub fn add_reference(&mut self, mut record: ReferenceRecord, user: &str) {
        let is_first = self.results.references.iter().all(|r| r.scene != record.scene);
        record.name = if is_first { "reference".into() } else { format!("reference of {user}") };
        self.results.references.push(record);
    }
}

/// A scene with what was said about it.
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
