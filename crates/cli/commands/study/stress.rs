//! `dapple stress`: the catalogue of stiff and extreme cases, on this build and this machine.

use crate::args::study::StressArgs;
use crate::commands::study::checks::{Row, Table};
use crate::error::{self, Failure};
use crate::report;
use dapple_analysis::stress::{self, Case, Check, Effort};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::available_parallelism;
use std::time::Instant;

/// Runs the chosen cases.
pub fn run(arguments: &StressArgs) -> Result<ExitCode, Failure> {
    let cases = match &arguments.case {
        None => stress::catalogue(),
        Some(patterns) => stress::select(patterns).map_err(|pattern| {
            Failure::Arguments(format!(
                "no case '{}': give ids such as A03, or B* for all that begin with B",
                error::short(&pattern)
            ))
        })?,
    };
    let effort = if arguments.thorough { Effort::Thorough } else { Effort::Normal };
    let start = Instant::now();
    let told = |row: &Row| {
        if !arguments.json {
            report::result(&row.line());
        }
    };
    let table = Table::new(measure_all(&cases, effort, &told), start.elapsed().as_secs_f64());
    table.tell(arguments.json, arguments.output.as_deref().map(|folder| (folder, "stress")))
}

/// As many cases at a time as there are cores, the long ones first; then one by one those that look at the clock. Rows are
/// told and returned in the cases' order.
fn measure_all(cases: &[Case], effort: Effort, told: &(impl Fn(&Row) + Sync)) -> Vec<Row> {
    let mut order: Vec<usize> = (0..cases.len()).collect();
    order.sort_by_key(|&i| (cases[i].is_timed(), !cases[i].is_long()));
    let shared = order.partition_point(|&i| !cases[i].is_timed());
    let rows = Mutex::new(Rows { done: cases.iter().map(|_| None).collect(), told: 0 });
    let one = |i: usize| {
        let row = measure(&cases[i], effort);
        rows.lock().unwrap_or_else(PoisonError::into_inner).add(i, row, told);
    };
    let next = AtomicUsize::new(0);
    let workers = available_parallelism().map_or(1, Into::into).min(shared);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(&i) = order[..shared].get(next.fetch_add(1, Ordering::Relaxed)) {
                    one(i);
                }
            });
        }
    });
    order[shared..].iter().for_each(|&i| one(i));
    rows.into_inner().unwrap_or_else(PoisonError::into_inner).done.into_iter().flatten().collect()
}

/// Rows in the order of the cases, as far as they are done.
struct Rows {
    done: Vec<Option<Row>>,
    /// How many were told.
    told: usize,
}

impl Rows {
    fn add(&mut self, i: usize, row: Row, told: &impl Fn(&Row)) {
        self.done[i] = Some(row);
        while let Some(Some(row)) = self.done.get(self.told) {
            told(row);
            self.told += 1;
        }
    }
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
