//! `dapple stress`: the catalogue of numerical stress cases, on this build and machine.

use crate::args::study::StressArgs;
use crate::commands::study::checks::{Page, Row, Table};
use crate::error::{self, Failure};
use crate::progress::Bar;
use crate::say::say;
use crate::standard_output;
use dapple_verify::stress::{self, Case, Check, Effort};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::available_parallelism;
use std::time::Instant;

/// Runs the selected cases.
pub fn run(arguments: &StressArgs) -> Result<ExitCode, Failure> {
    let cases = match &arguments.case {
        None => stress::catalogue(),
        Some(patterns) => stress::select(patterns).map_err(|pattern| {
            Failure::Arguments(format!(
                "unknown case '{}': give ids such as A03, or B* for all ids that begin with B",
                error::short(&pattern)
            ))
        })?,
    };
    if arguments.list {
        cases.iter().for_each(|case| standard_output::result(&format!("{}  {}", case.id, case.title)));
        return Ok(ExitCode::SUCCESS);
    }
    let effort = if arguments.thorough { Effort::Thorough } else { Effort::Normal };
    let page = arguments.output.as_deref().map(|folder| Page::plan(folder, "stress")).transpose()?;
    let start = Instant::now();
    let bar = Bar::new(false);
    let told = |row: &Row| {
        if !arguments.json {
            bar.aside(|| standard_output::results(&row.line()));
        }
    };
    let rows = measure_all(&cases, effort, &bar, &told);
    bar.finish();
    Ok(Table::new(rows, start.elapsed().as_secs_f64()).tell(arguments.json, page.as_ref()))
}

/// Runs as many cases in parallel as there are cores, long ones first, and then timed cases one by one. Rows are
/// reported and returned in the order of the cases.
fn measure_all(cases: &[Case], effort: Effort, bar: &Bar, told: &(impl Fn(&Row) + Sync)) -> Vec<Row> {
    let mut order: Vec<usize> = (0..cases.len()).collect();
    order.sort_by_key(|&i| (cases[i].is_timed(), !cases[i].is_long()));
    let shared = order.partition_point(|&i| !cases[i].is_timed());
    let rows =
        Mutex::new(Rows { done: cases.iter().map(|_| None).collect(), told: 0, bar, start: Instant::now() });
    let one = |i: usize| {
        let row = measure(&cases[i], effort);
        rows.lock().unwrap_or_else(PoisonError::into_inner).add(i, &cases[i], row, told);
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

/// Finished rows, in the order of the cases.
struct Rows<'a> {
    done: Vec<Option<Row>>,
    /// Number of rows that were reported.
    told: usize,
    bar: &'a Bar,
    start: Instant,
}

impl Rows<'_> {
    fn add(&mut self, i: usize, case: &Case, row: Row, told: &impl Fn(&Row)) {
        self.done[i] = Some(row);
        self.advance(case);
        while let Some(Some(row)) = self.done.get(self.told) {
            told(row);
            self.told += 1;
        }
    }

    /// Shows the progress, on a bar or, without one, by a line at each tenth of the cases: the first rows may have to
    /// wait for long cases.
    fn advance(&self, case: &Case) {
        let (count, seconds) = (self.done.len(), self.start.elapsed().as_secs_f64());
        let done = self.done.iter().flatten().count();
        let what = format!("{done} of {count} cases");
        if self.bar.is_shown() {
            self.bar.show_task(done as f64 / count as f64, seconds, &format!("{what}, {} done", case.id));
        } else if 10 * done / count > 10 * (done - 1) / count && done < count {
            say(&format!("{what} after {seconds:.0} s"));
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
