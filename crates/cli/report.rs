//! What is said after a render: results on standard output, a summary for people on standard error.

use crate::known::Known;
use crate::ledger::Ledger;
use crate::load::Loaded;
use crate::machine;
use crate::output::{Outputs, Written};
use crate::standard_output;
use dapple_integrator::{Effect, MethodKind, Settings, Stats};
use serde::Serialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;

/// A line to standard output.
pub fn result(line: &str) {
    standard_output::write(format!("{}\n", printable(line)).as_bytes());
}

/// A line to standard error.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(line));
}

/// Text that does to a terminal what its letters say and nothing else: names and paths come from files, and control
/// characters in them could move the cursor, change colours or reorder a line. They become U+FFFD; line breaks stay.
pub fn printable(text: &str) -> Cow<'_, str> {
    let acts = |c: char| (c.is_control() && c != '\n') || reorders(c);
    match text.contains(acts) {
        true => text.replace(acts, "\u{fffd}").into(),
        false => text.into(),
    }
}

/// Characters that change the direction of the text after them (Unicode Bidirectional Algorithm, UAX #9, §2).
fn reorders(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The JSON object of `dapple render --json`.
#[derive(Serialize)]
pub struct Report {
    pub render_seconds: f64,
    pub load_seconds: f64,
    pub build_seconds: f64,
    pub samples: u64,
    pub rays: u64,
    pub mrays_per_second: f64,
    pub peak_memory_bytes: u64,
    pub bad_samples: u64,
    /// What altered the estimate.
    pub ledger: Ledger,
    pub triangles: usize,
    pub lights: usize,
    pub kernel: String,
    pub width: u32,
    pub height: u32,
    pub spp: u32,
    /// Before it had all that was asked for.
    pub stopped: bool,
    /// Pixels without any sample, where time or an interrupt ended the first round.
    pub unsampled_pixels: usize,
    /// Expected relative RMSE of the picture; null where it cannot be known.
    pub error_estimate: Option<f64>,
    /// Upper bound of the relative RMSE; null where it cannot be relied on.
    pub error_bound: Option<f64>,
    /// Whether a bound can be stated.
    pub error_reliable: bool,
    /// Why, or why not.
    pub error_why: String,
    #[serde(skip)]
    pub error_summary: String,
    /// Wall time of finding that out, beside `render_seconds`.
    pub error_seconds: f64,
    pub seed: u64,
    pub threads: usize,
    pub method: &'static str,
    /// How points are laid out: the path tracer's pattern.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern: Option<String>,
    /// How integrals are put together, and the points of each: the distribution tracer's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub combine: Option<String>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub plans: BTreeMap<String, String>,
    pub version: &'static str,
    /// Of PNG pictures, in stops; null without any.
    pub exposure: Option<f32>,
    /// `radiometric`, or `photometric` where they were divided by 683 lm/W; null without punctual lights of a file.
    pub light_unit: Option<String>,
    /// Where the pictures are.
    pub outputs: Vec<String>,
    /// Outputs that could not be written where they were asked for.
    pub not_written: Vec<String>,
    pub warnings: Vec<String>,
}

impl Report {
    /// Gathers what a finished render has to say.
    pub fn new(
        loaded: &Loaded,
        settings: &Settings,
        stats: &Stats,
        known: &Known,
        (outputs, written): (&Outputs, &Written),
    ) -> Self {
        let is_path = settings.kind() == MethodKind::Path;
        let plans = Effect::ALL
            .iter()
            .map(|(effect, name)| (name.to_string(), settings.plans.of(*effect).to_string()));
        Self {
            render_seconds: stats.seconds,
            load_seconds: loaded.load_seconds,
            build_seconds: loaded.build_seconds,
            samples: stats.samples,
            rays: stats.rays,
            mrays_per_second: stats.rays as f64 / 1e6 / stats.seconds.max(1e-9),
            peak_memory_bytes: machine::peak_memory_bytes(),
            bad_samples: stats.bad_sample_count,
            ledger: Ledger::new(settings, stats),
            triangles: loaded.scene.survey.triangles,
            lights: loaded.scene.lights.len(),
            kernel: stats.kernel.clone(),
            width: settings.size.0,
            height: settings.size.1,
            spp: stats.spp,
            stopped: stats.stopped,
            unsampled_pixels: 0,
            error_estimate: known.error,
            error_bound: known.bound,
            error_reliable: known.reliable,
            error_why: known.why.clone(),
            error_summary: known.summary(),
            error_seconds: known.seconds,
            seed: settings.seed,
            threads: stats.threads,
            method: crate::values::method_name(settings.kind()),
            pattern: is_path.then(|| settings.pattern.to_string()),
            combine: (!is_path).then(|| settings.combine().to_string()),
            plans: plans.filter(|_| !is_path).collect(),
            version: env!("CARGO_PKG_VERSION"),
            exposure: outputs.exposure(),
            light_unit: loaded.scene.light_unit.as_ref().map(|taken| taken.unit().to_string()),
            outputs: written.paths.iter().map(|p| p.display().to_string()).collect(),
            not_written: written.failed.iter().map(|p| p.display().to_string()).collect(),
            warnings: loaded.scene.warnings.iter().map(|w| w.0.clone()).collect(),
        }
    }

    /// Two lines for people.
    pub fn summary(&self) -> String {
        let error = &self.error_summary;
        format!(
            "{}x{}, {} samples per pixel ({}, {}, seed {}), {} threads, {}\n\
             loaded in {:.2} s, built in {:.2} s, rendered in {:.2} s: {:.1} M rays, {:.2} Mrays/s; peak {:.0} MB{error}",
            self.width,
            self.height,
            self.spp,
            self.method,
            self.pattern.as_ref().or(self.combine.as_ref()).map_or("", String::as_str),
            self.seed,
            self.threads,
            self.kernel,
            self.load_seconds,
            self.build_seconds,
            self.render_seconds,
            self.rays as f64 / 1e6,
            self.mrays_per_second,
            self.peak_memory_bytes as f64 / 1e6,
        )
    }
}

/// One JSON object, on a line of its own.
pub fn json(value: &impl Serialize) {
    match serde_json::to_string(value) {
        Ok(line) => result(&line),
        Err(e) => say(&format!("error: the result cannot be written as JSON: {e}")),
    }
}

/// Sets how much is logged to standard error: with `-v` what is done, step by step.
pub fn start(options: &crate::options::RenderOptions) {
    use tracing_subscriber::EnvFilter;
    let level = if crate::options::RenderOptions::is(options.verbose) { "dapple=info" } else { "error" };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(level));
    // A second call, from a test, changes nothing.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .without_time()
        .try_init();
}

#[cfg(test)]
mod tests {
    use super::printable;

    #[test]
    fn nothing_acts_on_the_terminal() {
        assert_eq!(printable("Überblick – 1.5 µm\nnext"), "Überblick – 1.5 µm\nnext");
        assert_eq!(
            printable("a\u{1b}[2Jb\rc\u{9b}d\te\0"),
            "a\u{fffd}[2Jb\u{fffd}c\u{fffd}d\u{fffd}e\u{fffd}"
        );
        assert_eq!(printable("exe.\u{202e}gpj"), "exe.\u{fffd}gpj");
    }
}
