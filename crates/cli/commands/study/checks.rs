//! Results of checks, as a table, as JSON and as an HTML page.

use crate::error::Failure;
use crate::say::say;
use crate::{saving, standard_output};
use dapple_integrator::imaging::write;
use dapple_verify::stress::Outcome;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Exit code when checks fail.
const FAILED: u8 = 1;

/// One check and its result.
#[derive(Serialize)]
pub struct Row {
    pub id: String,
    pub family: String,
    pub title: String,
    /// Typical failure of naive renderers.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub naive: &'static str,
    pub source: &'static str,
    /// Why the check does not run; null if it runs.
    pub pending: Option<&'static str>,
    /// Whether the check passed; null if it is pending.
    pub passed: Option<bool>,
    #[serde(flatten)]
    pub numbers: Option<Numbers>,
    pub seconds: f64,
}

/// Numbers of a result that JSON can represent: null if not finite.
#[derive(Serialize)]
pub struct Numbers {
    pub expected: Option<f64>,
    pub measured: Option<f64>,
    /// Standard error; 0 if nothing is random.
    pub error: Option<f64>,
    pub tolerance: Option<f64>,
    /// |measured − expected| over the standard error, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_errors: Option<f64>,
    /// Exponent of the mean squared error as a function of the number of samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    pub note: String,
}

impl From<&Outcome> for Numbers {
    fn from(o: &Outcome) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        Self {
            expected: finite(o.expected),
            measured: finite(o.measured),
            error: finite(o.error),
            tolerance: finite(o.tolerance),
            standard_errors: None,
            rate: None,
            note: o.note.clone(),
        }
    }
}

/// All checks of a run.
#[derive(Serialize)]
pub struct Table {
    pub version: &'static str,
    pub passed: usize,
    pub failed: usize,
    pub pending: usize,
    pub seconds: f64,
    pub cases: Vec<Row>,
}

impl Row {
    fn verdict(&self) -> &'static str {
        match (self.passed, self.pending) {
            (Some(true), _) => "pass",
            (Some(false), _) => "FAIL",
            (None, _) => "pending",
        }
    }

    /// Formats the check as one line of the table.
    pub fn line(&self) -> String {
        let (id, verdict, title) = (&self.id, self.verdict(), &self.title);
        let said = match (&self.numbers, self.pending) {
            (Some(n), _) => {
                format!(
                    "{} of {} ± {}; {}",
                    number(n.measured),
                    number(n.expected),
                    number(n.tolerance),
                    n.note
                )
            }
            (None, Some(reason)) => reason.to_string(),
            (None, None) => String::new(),
        };
        let naive =
            if self.naive.is_empty() { String::new() } else { format!("\n      naive: {}", self.naive) };
        format!("{id}  {verdict:7}  {:6.2} s  {title}: {said}{naive}", self.seconds)
    }
}

fn number(x: Option<f64>) -> String {
    match x {
        None => "not finite".into(),
        Some(x) if x == 0.0 || (1e-3..1e6).contains(&x.abs()) => format!("{x:.6}"),
        Some(x) => format!("{x:.3e}"),
    }
}

/// An HTML page to write.
pub struct Page {
    path: PathBuf,
    title: &'static str,
}

impl Page {
    /// Prepares `folder/TITLE.html`: creates the folder and checks that the file can be written.
    pub fn plan(folder: &Path, title: &'static str) -> Result<Self, Failure> {
        let wrong = |e| Failure::Arguments(format!("-o {}: cannot be created: {e}", folder.display()));
        fs::create_dir_all(folder).map_err(wrong)?;
        let path = folder.join(format!("{title}.html"));
        write::probe(&path)?;
        Ok(Self { path, title })
    }
}

impl Table {
    pub fn new(cases: Vec<Row>, seconds: f64) -> Self {
        let count = |passed| cases.iter().filter(|row| row.passed == passed).count();
        let (passed, failed, pending) = (count(Some(true)), count(Some(false)), count(None));
        Self { version: env!("CARGO_PKG_VERSION"), passed, failed, pending, seconds, cases }
    }

    /// Reports the results, and returns the exit code.
    pub fn tell(&self, json: bool, page: Option<&Page>) -> ExitCode {
        if let Some(Page { path, title }) = page {
            let bytes = self.page(title).into_bytes();
            if let Some(at) = saving::save(path, |path| write::replace(path, &bytes)) {
                say(&format!("wrote {}", at.display()));
            }
        }
        if json {
            standard_output::json(self);
        }
        let Self { passed, failed, pending, seconds, .. } = self;
        say(&format!("{passed} pass, {failed} fail, {pending} pending; {seconds:.1} s"));
        if *failed > 0 { ExitCode::from(FAILED) } else { ExitCode::SUCCESS }
    }

    fn page(&self, title: &str) -> String {
        let Self { version, passed, failed, pending, seconds, .. } = self;
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width";
                    title { "dapple " (title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    h1 { "dapple " (title) }
                    p {
                        "dapple " (version) ": " (passed) " pass, " (failed) " fail, " (pending) " pending, in "
                        (format!("{seconds:.1}")) " s."
                    }
                    table {
                        tr { @for head in HEADS { th { (head) } } }
                        @for row in &self.cases { (html_row(row)) }
                    }
                }
            }
        };
        page.into_string()
    }
}

const HEADS: [&str; 8] =
    ["case", "result", "expected", "measured", "standard error", "tolerance", "seconds", "description"];

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;margin:2em auto;max-width:75em;padding:0 1em;color:#222;\
    background:#fff}table{border-collapse:collapse}td,th{padding:.35em .6em;border-bottom:1px solid #ddd;text-align:left;\
    vertical-align:top}td.n{font-variant-numeric:tabular-nums;white-space:nowrap}.pass{color:#17692d}.FAIL{color:#b00020;\
    font-weight:700}.pending{color:#666}small{color:#555}";

fn html_row(row: &Row) -> Markup {
    let verdict = row.verdict();
    let numbers = row.numbers.as_ref().map(|n| [n.expected, n.measured, n.error, n.tolerance]);
    let note = row.numbers.as_ref().map_or(row.pending.unwrap_or_default(), |n| &n.note);
    html! {
        tr {
            td { (row.id) }
            td class=(verdict) { (verdict) }
            @for i in 0..4 { td.n { @if let Some(n) = numbers { (number(n[i])) } } }
            td.n { (format!("{:.2}", row.seconds)) }
            td {
                (row.title)
                @if !row.naive.is_empty() { br; "Naive: " (row.naive) }
                br;
                small { (note) br; (row.source) }
            }
        }
    }
}
