//! `dapple stress`: the catalogue of stiff and extreme cases, on this build and this machine.

use crate::args::study::StressArgs;
use crate::commands::study::checks::{Row, Table};
use crate::error::Failure;
use crate::report;
use dapple_analysis::stress::{self, Case, Check, Effort};
use std::process::ExitCode;
use std::time::Instant;

/// Runs the chosen cases one by one.
pub fn run(arguments: &StressArgs) -> Result<ExitCode, Failure> {
    let cases = match &arguments.case {
        None => stress::catalogue(),
        Some(patterns) => stress::select(patterns).map_err(|pattern| {
            Failure::Arguments(format!(
                "no case '{pattern}': give ids such as A03, or B* for all that begin with B"
            ))
        })?,
    };
    let effort = if arguments.thorough { Effort::Thorough } else { Effort::Normal };
    let start = Instant::now();
    let mut rows = Vec::with_capacity(cases.len());
    for case in &cases {
        let row = measure(case, effort);
        if !arguments.json {
            report::result(&row.line());
        }
        rows.push(row);
    }
    let table = Table::new(rows, start.elapsed().as_secs_f64());
    table.tell(arguments.json, arguments.output.as_deref().map(|folder| (folder, "stress")))
}

fn measure(case: &Case, effort: Effort) -> Row {
    let start = Instant::now();
    let outcome = case.run(effort);
    Row {
        id: case.id.into(),
        family: case.family().into(),
        title: case.title.into(),
        naive: case.naive,
        source: case.source,
        pending: match case.check {
            Check::Pending(reason) => Some(reason),
            Check::Run(_) => None,
        },
        passed: outcome.as_ref().map(|o| o.passed),
        numbers: outcome.as_ref().map(Into::into),
        seconds: start.elapsed().as_secs_f64(),
    }
}
