//! `dapple verify`: checks both tracers and every estimator against closed-form solutions, on this build and machine.

use crate::args::study::VerifyArgs;
use crate::commands::study::checks::{Numbers, Row, Table};
use crate::error::Failure;
use crate::standard_output;
use dapple_verify::forms::{self, Form, Measured};
use std::process::ExitCode;
use std::time::Instant;

/// Number of independent renders per tracer and estimator.
const REPLICAS: u64 = 400;

/// Runs all checks.
pub fn run(arguments: &VerifyArgs) -> Result<ExitCode, Failure> {
    let start = Instant::now();
    let mut rows = Vec::new();
    for form in forms::all()? {
        let begun = Instant::now();
        let measured = forms::measure(&form, REPLICAS);
        let seconds = begun.elapsed().as_secs_f64() / measured.len() as f64;
        for row in measured.iter().map(|m| row(&form, m, seconds)) {
            if !arguments.json {
                standard_output::results(&row.line());
            }
            rows.push(row);
        }
    }
    Ok(Table::new(rows, start.elapsed().as_secs_f64()).tell(arguments.json, None))
}

fn row(form: &Form, measured: &Measured, seconds: f64) -> Row {
    let outcome = &measured.outcome;
    let mut numbers = Numbers::from(outcome);
    let errors = (outcome.measured - outcome.expected).abs() / outcome.error;
    numbers.standard_errors = errors.is_finite().then_some(errors);
    numbers.rate = measured.rate;
    if let Some(errors) = numbers.standard_errors {
        numbers.note += &format!(", off by {errors:.1} standard errors");
    }
    if let Some(rate) = measured.rate {
        numbers.note += &format!(", error falls as n^{rate:.2}");
    }
    Row {
        id: format!("{}/{}/{}", form.id, measured.method, measured.pattern),
        family: "closed forms".into(),
        title: form.title.into(),
        naive: "",
        source: form.source,
        pending: None,
        passed: Some(outcome.passed),
        numbers: Some(numbers),
        seconds,
    }
}
