//! `dapple merge`: the image of a render from its parts, without the scene.

use crate::args::MergeArgs;
use crate::bias_report::BiasReport;
use crate::checkpoint::identity;
use crate::error::{self, Failure};
use crate::inputs::Inputs;
use crate::known::Known;
use crate::output::{Outputs, Written};
use crate::part::{PartFile, judged, ranges};
use crate::say::{say, say_lines};
use crate::values::SampleRange;
use crate::{known, options::RenderOptions, standard_output};
use dapple_integrator::{Covered, Outcome, PartError, Settings, missing};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Merges the parts and writes the outputs.
pub fn run(arguments: &MergeArgs) -> Result<ExitCode, Failure> {
    let mut inputs = Inputs::default();
    arguments.parts.iter().for_each(|path| inputs.add("a part", path));
    let options = options(arguments);
    let mut outputs = Outputs::plan(&options, "merged")?;
    inputs.spare(outputs.paths())?;
    let merged = merge(&arguments.parts)?;
    let is_image = outputs.paths().count() > outputs.parts().count();
    let whole = Whole::of(&merged, is_image, arguments.allow_gaps)?;
    outputs.expose(|| merged.notes.exposure);
    let damaged = |e: PartError| Failure::Arguments(e.to_string());
    let mut outcome = merged.part.outcome(whole.spp).map_err(damaged)?;
    let attributes = merged.notes.attributes(whole.spp, whole.samples.as_ref(), whole.crop);
    outcome.layers.metadata.extend(attributes);
    let confidence = arguments.confidence.unwrap_or(known::CONFIDENCE);
    let known = judged(&merged.errors, &outcome, confidence);
    let mut written = outputs.write(&outcome, &outcome.film.mean(), None);
    if outputs.parts().next().is_some() {
        let bytes = merged.encode(&outcome.film).map_err(Failure::Arguments)?;
        outputs.write_parts(&bytes, true, &mut written);
    }
    let report = Report::new(arguments, &merged, &outcome, &known, (&outputs, &written));
    if !arguments.quiet {
        say_lines(&report.summary(&known));
        report.bias.summary().iter().for_each(|line| say(line));
    }
    if arguments.json {
        standard_output::json(&report);
    } else {
        report.outputs.iter().for_each(|path| standard_output::result(path));
    }
    Ok(ExitCode::SUCCESS)
}

/// The options of the outputs.
fn options(arguments: &MergeArgs) -> RenderOptions {
    RenderOptions {
        output: Some(arguments.output.clone()),
        half: Some(arguments.half),
        tone: arguments.tone,
        exposure: arguments.exposure,
        png_depth: arguments.png_depth,
        ..RenderOptions::default()
    }
}

/// The error of a part that is not merged.
fn refused(path: &Path, why: &str) -> Failure {
    Failure::Arguments(format!("{}: {}", path.display(), error::one_line(why)))
}

/// Reads and merges the parts, one at a time, in the order of their samples.
fn merge(paths: &[PathBuf]) -> Result<PartFile, Failure> {
    let mut order = Vec::new();
    for path in paths {
        let file = PartFile::read(path).map_err(|why| refused(path, &why))?;
        let first = file.part.covered().iter().map(|c| (c.samples.start, c.rect.y0, c.rect.x0)).min();
        order.push((first, path));
    }
    order.sort();
    let mut merged: Option<(PartFile, &Path)> = None;
    for (_, path) in order {
        let file = PartFile::read(path).map_err(|why| refused(path, &why))?;
        merged = Some(match merged {
            None => (file, path),
            Some((all, first)) => (both(all, first, file, path)?, first),
        });
    }
    let none = || Failure::Arguments("there are no parts to merge".into());
    merged.map(|(all, _)| all).ok_or_else(none)
}

/// Merges two parts, of which `all` begins with the one in the file `first`.
fn both(mut all: PartFile, first: &Path, file: PartFile, path: &Path) -> Result<PartFile, Failure> {
    let other =
        |why: String| refused(path, &format!("it is not of the same render as {}: {why}", first.display()));
    if let Some(why) = identity::difference(&all.about, &file.about) {
        return Err(other(why));
    }
    if all.notes != file.notes {
        return Err(other(match (all.notes.of, file.notes.of) {
            (ours, theirs) if ours != theirs => {
                let show = |of: Option<u32>| of.map_or("no end".into(), |of| format!("{of} samples"));
                format!("its set has {} instead of {}; give both the same --spp", show(theirs), show(ours))
            }
            _ => "it was written with other options".into(),
        }));
    }
    match all.part.merge(file.part) {
        Ok(()) => {}
        Err(PartError::Overlap(both)) => {
            let which = ranges(std::slice::from_ref(&both));
            return Err(refused(
                path,
                &format!("samples {which} are in another part too; leave one of them out"),
            ));
        }
        Err(PartError::Other) => return Err(other("its settings or the size of its set differ".into())),
        Err(error) => return Err(refused(path, &error.to_string())),
    }
    all.errors.merge(file.errors);
    Ok(all)
}

/// How much of an image the merged parts are.
struct Whole {
    /// Samples per pixel, or on average if some are missing.
    spp: u32,
    /// The samples, if they are not all.
    samples: Option<SampleRange>,
    /// The pixels, if they are not all.
    crop: Option<[u32; 4]>,
}

impl Whole {
    /// Fails if samples are missing and that is not allowed.
    /// A larger part only has to have no gaps within.
    fn of(merged: &PartFile, is_image: bool, allow_gaps: bool) -> Result<Self, Failure> {
        let (covered, rect) = (merged.part.covered(), merged.part.rect());
        let end = covered.iter().map(|c| c.samples.end).max().unwrap_or_default();
        let of = merged.notes.of.unwrap_or(end);
        let start = covered.iter().map(|c| c.samples.start).min().unwrap_or_default();
        let gaps = missing(covered, rect, if is_image { 0..of } else { start..end });
        let (width, height) = merged.part.size();
        let is_frame = (rect.x0, rect.y0, rect.x1, rect.y1) == (0, 0, width, height);
        let crop = (!is_frame).then_some([rect.x0, rect.y0, rect.x1, rect.y1]);
        if gaps.is_empty() {
            return Ok(Self { spp: if is_image { of } else { end - start }, samples: None, crop });
        }
        let said = format!("samples {} are missing", ranges(&gaps));
        if !allow_gaps {
            return Err(Failure::Arguments(format!(
                "{said}; render them, or merge without them by --allow-gaps"
            )));
        }
        say(&format!("warning: {said}; the image has the others"));
        let count = |c: &Covered| c.rect.area() as u64 * u64::from(c.samples.end - c.samples.start);
        let spp = covered.iter().map(count).sum::<u64>() / rect.area().max(1) as u64;
        let samples = Some(SampleRange { start, end });
        Ok(Self { spp: u32::try_from(spp).unwrap_or(u32::MAX).max(1), samples, crop })
    }
}

/// The JSON object of `dapple merge --json`.
#[derive(Serialize)]
struct Report {
    /// Number of merged files.
    parts: usize,
    width: u32,
    height: u32,
    /// Samples per pixel; the mean if they differ.
    spp: u32,
    samples: u64,
    rays: u64,
    /// Sum of the times of all parts.
    render_seconds: f64,
    error_estimate: Option<f64>,
    error_bound: Option<f64>,
    error_reliable: bool,
    error_why: String,
    /// Sum of the times that the parts spent on the error estimate.
    error_seconds: f64,
    #[serde(rename = "ledger")]
    bias: BiasReport,
    bad_samples: u64,
    seed: u64,
    method: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pattern: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    combine: Option<String>,
    version: &'static str,
    exposure: Option<f32>,
    outputs: Vec<String>,
    not_written: Vec<String>,
}

impl Report {
    fn new(
        arguments: &MergeArgs,
        merged: &PartFile,
        outcome: &Outcome,
        known: &Known,
        (outputs, written): (&Outputs, &Written),
    ) -> Self {
        let (notes, stats) = (&merged.notes, &outcome.stats);
        let settings = Settings {
            ambient: notes.ambient,
            transparent_shadows: notes.transparent_shadows,
            ..Settings::default()
        };
        let settings = settings.with_path(|p| p.roulette = notes.roulette);
        let (width, height) = merged.part.size();
        let paths = |all: &[PathBuf]| all.iter().map(|path| path.display().to_string()).collect();
        Self {
            parts: arguments.parts.len(),
            width,
            height,
            spp: stats.spp,
            samples: stats.samples,
            rays: stats.rays,
            render_seconds: stats.seconds,
            error_estimate: known.error,
            error_bound: known.bound,
            error_reliable: known.reliable,
            error_why: known.why.clone(),
            error_seconds: known.seconds,
            bias: BiasReport::new(&settings, stats),
            bad_samples: stats.bad_sample_count,
            seed: notes.seed,
            method: notes.method.clone(),
            pattern: notes.pattern.clone(),
            combine: notes.combine.clone(),
            version: env!("CARGO_PKG_VERSION"),
            exposure: outputs.exposure(),
            outputs: paths(&written.paths),
            not_written: paths(&written.failed),
        }
    }

    /// Formats the summary for people.
    fn summary(&self, known: &Known) -> String {
        format!(
            "{}x{}, {} samples per pixel ({}, {}, seed {}) from {} parts, rendered in {:.2} s: {:.1} M rays{}",
            self.width,
            self.height,
            self.spp,
            self.method,
            self.pattern.as_ref().or(self.combine.as_ref()).map_or("", String::as_str),
            self.seed,
            self.parts,
            self.render_seconds,
            self.rays as f64 / 1e6,
            match known.error {
                Some(_) => known.summary(),
                None => format!("\nno error estimate: {}", known.why),
            },
        )
    }
}
