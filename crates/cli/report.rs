//! Report of a finished render: a JSON object for programs, and a summary for people.

use crate::bias_report::BiasReport;
use crate::known::Known;
use crate::load::Loaded;
use crate::machine;
use crate::output::{Outputs, Written};
use dapple_integrator::{Effect, MethodKind, Settings, Stats};
use serde::Serialize;
use std::collections::BTreeMap;

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
    /// Deliberate biases of the estimate.
    #[serde(rename = "ledger")]
    pub bias: BiasReport,
    pub triangles: usize,
    pub lights: usize,
    pub kernel: String,
    pub width: u32,
    pub height: u32,
    /// The crop as a part of the summary.
    #[serde(skip)]
    pub crop_words: String,
    pub spp: u32,
    /// Whether the render ended before it had all requested samples.
    pub stopped: bool,
    /// Pixels without any sample, if time or an interrupt ended the first round.
    pub unsampled_pixels: usize,
    /// Expected relative RMSE of the image; null if it cannot be estimated.
    pub error_estimate: Option<f64>,
    /// Upper bound of the relative RMSE; null if no bound is reliable.
    pub error_bound: Option<f64>,
    /// Whether a reliable bound exists.
    pub error_reliable: bool,
    /// Reason why there is a bound, or why there is none.
    pub error_why: String,
    #[serde(skip)]
    pub error_summary: String,
    /// Wall-clock time spent on the error estimate, in addition to `render_seconds`.
    pub error_seconds: f64,
    pub seed: u64,
    pub threads: usize,
    pub method: &'static str,
    /// Sampling pattern of the path tracer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern: Option<String>,
    /// Combination of the integrals of the distribution tracer; `plans` holds the sample set of each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub combine: Option<String>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub plans: BTreeMap<String, String>,
    pub version: &'static str,
    /// Exposure of PNG output, in stops; null if none is written.
    pub exposure: Option<f32>,
    /// `radiometric`, or `photometric` if intensities were divided by 683 lm/W; null without punctual lights from a
    /// file.
    pub light_unit: Option<String>,
    /// Paths of the written images.
    pub outputs: Vec<String>,
    /// Outputs that could not be written where they were requested.
    pub not_written: Vec<String>,
    pub warnings: Vec<String>,
}

impl Report {
    /// Collects the results of a finished render.
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
            bias: BiasReport::new(settings, stats),
            triangles: loaded.scene.survey.triangles,
            lights: loaded.scene.lights.len(),
            kernel: stats.kernel.clone(),
            width: settings.size.0,
            height: settings.size.1,
            crop_words: settings.crop.map_or_else(String::new, |c| {
                format!(" cropped to {}x{} at {},{}", c.width(), c.y1 - c.y0, c.x0, c.y0)
            }),
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

    /// Formats the summary for people, in two lines.
    pub fn summary(&self) -> String {
        let error = &self.error_summary;
        format!(
            "{}x{}{}, {} samples per pixel ({}, {}, seed {}), {} threads, {}\n\
             loaded in {:.2} s, built in {:.2} s, rendered in {:.2} s: {:.1} M rays, {:.2} Mrays/s; peak {:.0} MB{error}",
            self.width,
            self.height,
            self.crop_words,
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
