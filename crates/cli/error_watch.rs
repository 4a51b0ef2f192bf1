//! Estimates the error of a running render: for the progress bar, the log, and the stopping rule of `--error-limit`.

use crate::error::Failure;
use crate::interrupt;
use crate::known::Known;
use crate::options::RenderOptions;
use crate::progress::Bar;
use crate::saving;
use dapple_analysis::estimate::{
    Doublings, Estimate, SHARE, Verdict, Way, replicate_until, replicated_share, unseen, variances, within,
};
use dapple_analysis::statistics;
use dapple_integrator::camera::{Camera, Film};
use dapple_integrator::scene::Scene;
use dapple_integrator::{Outcome, Peak, SampleAllocation, Settings, Snapshot, Tail, peak};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::cell::{Cell, OnceCell};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Fewest samples per pixel at which the error can stop a render: with fewer, rare bright samples may be missing.
const FEWEST: u32 = 64;

/// An estimate above the limit by more than this factor rules out that the error is below the limit.
const HOPE: f64 = 1.5;

/// The next check is scheduled where the bound is expected to reach this fraction of the limit, as a margin for chance.
const AIM: f64 = 0.95;

/// Minimum growth factor of the samples between two checks: each check costs time and confidence.
const STEP: f64 = 1.125;

/// Maximum growth factor, so that samples taken in between which already suffice do not go unnoticed for long.
const LEAP: f64 = 4.0;

/// Cap on a render whose bound is not reliable and that has no other limit: a multiple of the samples at which the
/// limit would have been reached, and a minimum number of samples.
const CAP: (u32, u32) = (16, 4096);

/// Number of samples in each independent set of the path tracer.
const WHOLE: u32 = 16;

/// The part of an error watch that a checkpoint holds: what later checks depend on.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Saved {
    doublings: Option<Doublings>,
    reached: Option<u32>,
    is_capped: bool,
    looks: i32,
    next: Option<u32>,
    held: Option<Verdict>,
    /// If the last check was not completed, whether it was between two regular ones: it is due again.
    due: Option<bool>,
}

/// Checks a render at each doubling of its samples, and in between where that is worthwhile.
pub struct ErrorWatch<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    settings: &'a Settings,
    way: Way,
    doublings: Option<Doublings>,
    confidence: f64,
    limit: Option<f64>,
    /// Whether neither a sample count nor a time limit ends the render.
    is_endless: bool,
    /// Samples at which the bound first fell below the limit, whether reliable or not.
    reached: Option<u32>,
    /// Whether the cap ended the render.
    is_capped: bool,
    /// Upper bound of a sample's radiance.
    peak: OnceCell<Peak>,
    /// Number of checks of the limit so far.
    looks: i32,
    /// Samples at which the next check is due.
    next: Option<u32>,
    log: Option<(PathBuf, File)>,
    bar: &'a Bar,
    /// Verdict of the check that found the limit reached.
    held: Option<Verdict>,
    /// Whether the last line of the log has an error.
    told: bool,
    /// Whether a measurement was cut short, by a signal or by the end of the time.
    is_cut: Cell<bool>,
    /// What was saved before a check that was not completed.
    undone: Option<Saved>,
    /// Seconds spent on measuring the error, apart from rendering.
    seconds: Cell<f64>,
    /// Deadline of the command, if time is limited.
    deadline: Option<Instant>,
}

/// Fraction of an image to render again above which no time is reserved for it.
const WORTH: f64 = 0.5;

impl<'a> ErrorWatch<'a> {
    /// Returns the fraction of the time limit that is needed to measure the error of the finished image.
    pub fn share_of_time(settings: &Settings) -> f64 {
        let again = 1.1 * replicated_share(settings.rect());
        if Way::of(settings) == Way::Replicate && again <= WORTH { again / (1.0 + again) } else { 0.0 }
    }

    /// Creates the watch of a render with `settings`; fails if the log cannot be written or the error limit has no
    /// meaning.
    pub fn new(
        (scene, camera, settings): (&'a Scene, &'a Camera, &'a Settings),
        options: &RenderOptions,
        bar: &'a Bar,
    ) -> Result<Self, Failure> {
        let (way, doublings) = (Way::of(settings), Doublings::new(settings));
        if options.error_limit.is_some() && (way == Way::None || doublings.is_none()) {
            let said = "the error cannot be estimated during the render with these samples; use --pattern sobol or \
                        random, omit --spp with stratified, and do not use grid";
            return Err(Failure::Arguments(format!("--error-limit: {said}")));
        }
        // The log of a render that is resumed continues.
        let is_resumed = options.long.resume.as_ref().is_some_and(|path| path.exists());
        let mut how = OpenOptions::new();
        how.create(true).write(true).append(is_resumed).truncate(!is_resumed);
        let open = |path: &PathBuf| match how.open(path) {
            Ok(file) => Ok((path.clone(), file)),
            Err(e) => Err(Failure::Arguments(format!("--log {}: cannot be written: {e}", path.display()))),
        };
        Ok(Self {
            scene,
            camera,
            settings,
            way,
            doublings: doublings.filter(|_| way != Way::None),
            confidence: options.confidence.unwrap_or(statistics::CONFIDENCE),
            limit: options.error_limit,
            is_endless: options.spp.is_none() && options.time_limit.is_none(),
            reached: None,
            is_capped: false,
            peak: OnceCell::new(),
            looks: 0,
            next: None,
            log: options.log.as_ref().map(open).transpose()?,
            bar,
            held: None,
            told: false,
            is_cut: Cell::new(false),
            undone: None,
            seconds: Cell::new(0.0),
            deadline: settings.limits.time.and_then(|limit| Instant::now().checked_add(limit)),
        })
    }

    /// Returns what a resumed render needs.
    pub fn saved(&self) -> Saved {
        self.undone.clone().unwrap_or_else(|| self.progress())
    }

    fn progress(&self) -> Saved {
        Saved {
            due: None,
            doublings: self.doublings.clone(),
            reached: self.reached,
            is_capped: self.is_capped,
            looks: self.looks,
            next: self.next,
            held: self.held.clone(),
        }
    }

    /// Continues where the watch of an interrupted render was; it took `elapsed`. Returns whether a check of the
    /// present samples is due, and if so whether it is between two regular ones.
    pub fn resume(&mut self, saved: Saved, elapsed: Duration) -> Option<bool> {
        self.doublings = saved.doublings.filter(|_| self.doublings.is_some());
        (self.reached, self.is_capped) = (saved.reached, saved.is_capped);
        (self.looks, self.next, self.held) = (saved.looks, saved.next, saved.held);
        self.deadline = self.deadline.and_then(|deadline| deadline.checked_sub(elapsed));
        saved.due
    }

    /// Whether the render needs no further samples.
    pub fn is_done(&self) -> bool {
        self.held.is_some() || self.is_capped
    }

    /// Processes a snapshot; breaks when the error is small enough.
    pub fn look(&mut self, at: &Snapshot<'_>) -> ControlFlow<()> {
        let before = self.limit.map(|_| self.progress());
        self.is_cut.set(false);
        let known = self.guess(at);
        // A resumed render repeats the check, so that it ends at the samples at which it would have ended.
        let undone = before.filter(|_| self.is_cut.get());
        self.undone = undone.map(|before| Saved { due: Some(at.between), ..before });
        self.write((at.seconds, at.spp, at.rays()), known.as_ref());
        if self.is_done() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Returns the sample count of an additional snapshot, at which the next check is due.
    pub fn next(&self) -> Option<u32> {
        self.next
    }

    /// Estimates the error from the change of the image; measures it where it may be below the limit.
    fn guess(&mut self, at: &Snapshot<'_>) -> Option<Verdict> {
        let doublings = self.doublings.as_mut()?;
        let film = at.film();
        if !at.between {
            doublings.add(at.spp, film.mean());
        }
        let (guess, rate) = (doublings.estimate(self.confidence)?, doublings.rate());
        self.bar.set_error(Some(guess.error));
        let limit = self.limit.filter(|limit| match self.next {
            None => at.spp >= FEWEST && guess.error <= HOPE * limit,
            Some(next) => at.spp >= next,
        });
        let Some(limit) = limit else {
            return self.log.is_some().then(|| self.judge(guess, (&film, &at.tail()), self.confidence));
        };
        Some(self.examine(at, &film, (guess, rate), limit))
    }

    /// Checks whether the limit is reached, and schedules the next check if it is not.
    fn examine(
        &mut self,
        at: &Snapshot<'_>,
        film: &Film,
        (guess, rate): (Estimate, f64),
        limit: f64,
    ) -> Verdict {
        let tail = at.tail();
        if guess.bound <= limit {
            self.reached.get_or_insert(at.spp);
        }
        let doubt = self.judge(guess, (film, &tail), self.confidence(self.looks + 1));
        let (found, verdict) = if doubt.unseen > SHARE * limit {
            // The limit cannot be reached yet: skip the measurement, which would spend part of the confidence.
            (guess, doubt)
        } else {
            self.looks += 1;
            let measured = self.measure(film, at.spp, at.allocation).unwrap_or(guess);
            (measured, self.judge(measured, (film, &tail), self.confidence(self.looks)))
        };
        self.held = Some(verdict.clone()).filter(|v| v.reliable && v.bound <= limit);
        let cap = self.cap();
        self.is_capped = at.spp >= cap;
        let next = self.worth(at.spp, (found, &verdict), limit, rate).min(cap);
        self.next = Some(next);
        verdict
    }

    /// Returns the samples at which a render ends even though its bound is not reliable.
    fn cap(&self) -> u32 {
        let reached = self.reached.filter(|_| self.is_endless);
        reached.map_or(u32::MAX, |spp| spp.saturating_mul(CAP.0).max(CAP.1))
    }

    /// Combines an error estimate with the possible contribution of light that no sample has found.
    fn judge(&self, found: Estimate, (film, tail): (&Film, &Tail), confidence: f64) -> Verdict {
        let start = Instant::now();
        let peak = self.peak.get_or_init(|| peak(self.scene, self.camera, self.settings));
        let verdict = Verdict::new(found, unseen(film, tail, peak, confidence), self.limit);
        self.seconds.set(self.seconds.get() + start.elapsed().as_secs_f64());
        verdict
    }

    /// Returns the samples at which the next check's bound is likely to be below the limit and reliable, given that
    /// `spp` samples had the error `found` and that its square falls by `rate`; a multiple of whole sample sets.
    fn worth(&self, spp: u32, (found, verdict): (Estimate, &Verdict), limit: f64, rate: f64) -> u32 {
        let of = [0, 1].map(|more| self.confidence(self.looks + more));
        let more = verdict.growth(found.bound_of(of), AIM * limit, rate, LEAP).max(STEP);
        let samples = f64::from(spp) * if more.is_finite() { more } else { STEP };
        (samples as u32).checked_next_multiple_of(WHOLE).unwrap_or(u32::MAX)
    }

    /// Confidence of each bound, corrected for repeated checks: stopping when one of many bounds happens to be small is
    /// wrong more often than each bound alone. The first check gets half of the permitted probability of error, the
    /// next one half of the remainder, so that the sum stays below it (Boole's inequality).
    fn confidence(&self, looks: i32) -> f64 {
        1.0 - (1.0 - self.confidence) * 0.5f64.powi(looks)
    }

    /// Measures the error of an image of `spp` samples; renders a small part of it again where no other way exists.
    fn measure(&self, film: &Film, spp: u32, allocation: Option<&Arc<SampleAllocation>>) -> Option<Estimate> {
        let start = Instant::now();
        let found = match self.way {
            Way::Within => within(film, self.confidence(self.looks)),
            Way::Replicate if self.is_whole(spp) => {
                let settings = self.settings.clone().with_path(|p| p.allocation = allocation.cloned());
                let confidence = self.confidence(self.looks);
                let deadline = self.deadline;
                let stop = || interrupt::asked() || late(deadline);
                let within = variances(film);
                let (whole, scene) = ((film, spp), self.scene);
                let found = replicate_until(scene, self.camera, &settings, whole, &within, confidence, &stop);
                self.is_cut.set(self.is_cut.get() || stop());
                found
            }
            _ => None,
        };
        self.seconds.set(self.seconds.get() + start.elapsed().as_secs_f64());
        found
    }

    /// Whether `spp` completes a round. An incomplete round of the distribution tracer is no estimate: cells come in
    /// order.
    fn is_whole(&self, spp: u32) -> bool {
        spp.is_multiple_of(self.settings.round())
    }

    fn write(&mut self, (seconds, spp, rays): (f64, u32, u64), known: Option<&Verdict>) {
        let Some((path, file)) = &mut self.log else { return };
        self.told = known.is_some();
        let (error, bound) = (known.map(|v| v.error), known.filter(|v| v.reliable).map(|v| v.bound));
        let line = json!({ "seconds": seconds, "spp": spp, "rays": rays, "error": error, "bound": bound });
        if let Err(e) = writeln!(file, "{line}") {
            saving::lose();
            let said = format!(
                "error: --log {}: cannot be written: {e}; the render continues without it",
                path.display()
            );
            self.bar.say(&said);
            self.log = None;
        }
    }

    /// Returns the error of the finished image, and the seconds spent on measuring it. It is appended to the log as
    /// well if the last line has none.
    pub fn finish(mut self, outcome: &Outcome) -> Known {
        let stats = &outcome.stats;
        let measured = || self.measure(&outcome.film, stats.spp, outcome.allocation.as_ref());
        let guessed = || self.doublings.as_ref()?.estimate(self.confidence);
        let judged = || {
            let found = measured().or_else(guessed)?;
            Some(self.judge(found, (&outcome.film, &outcome.tail), self.confidence))
        };
        // Without one whole round there is no estimate, and no need to spend time on one.
        let found = if stats.spp > 0 { self.held.clone().or_else(judged) } else { None };
        if found.is_some() && !self.told {
            self.write((stats.seconds, stats.spp, stats.rays), found.as_ref());
        }
        let unknown = || match self.way {
            Way::None => "the error of these samples is not random: they are the same for every seed".into(),
            _ => "too few samples to estimate the error".into(),
        };
        Known {
            error: found.as_ref().map(|v| v.error),
            bound: found.as_ref().filter(|v| v.reliable).map(|v| v.bound),
            reliable: found.as_ref().is_some_and(|v| v.reliable),
            why: found.map_or_else(unknown, |v| v.why),
            seconds: self.seconds.get(),
        }
    }
}

/// Whether the deadline has passed.
fn late(deadline: Option<Instant>) -> bool {
    deadline.is_some_and(|deadline| Instant::now() >= deadline)
}
