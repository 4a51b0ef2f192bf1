//! Commands that compare images, renderers and estimators, one file each.

mod budget;
mod checks;
mod converge;
mod diff;
mod sheet;
mod stress;
mod verify;

use crate::args::study::Study;
use crate::error::Failure;
use clap::ArgMatches;
use std::process::ExitCode;

/// Runs one of the commands; `typed` records which options were given on the command line.
pub fn run(command: Study, typed: &ArgMatches) -> Result<ExitCode, Failure> {
    let done = |()| ExitCode::SUCCESS;
    match command {
        Study::Converge(a) => converge::run(&a, typed),
        Study::Budget(a) => budget::run(&a.scene, typed).map(done),
        Study::Diff(a) => diff::run(&a).map(done),
        Study::Stress(a) => stress::run(&a),
        Study::Verify(a) => verify::run(&a),
        Study::Sheet(a) => sheet::run(&a, typed),
    }
}
