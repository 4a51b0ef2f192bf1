//! What a render says about its own error: while it runs, in a log, and when it is enough.

use crate::error::Failure;
use crate::interrupt;
use crate::known::Known;
use crate::options::RenderOptions;
use crate::progress::Bar;
use crate::saving;
use dapple_analysis::estimate::{
    Doublings, Estimate, SHARE, Verdict, Way, replicate_until, replicated_share, unseen, within,
};
use dapple_analysis::statistics;
use dapple_integrator::camera::{Camera, Film};
use dapple_integrator::scene::Scene;
use dapple_integrator::{Outcome, Peak, SampleAllocation, Settings, Snapshot, Tail, peak};
use serde_json::json;
use std::cell::{Cell, OnceCell};
use std::fs::File;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// No render stops for its error before it has so many samples per pixel: with fewer, rare bright ones may be unseen.
const FEWEST: u32 = 64;

/// A guess so much above the limit leaves no hope that the error is below it.
const HOPE: f64 = 1.5;

/// The next look is where the bound is expected to be this part of the limit: chance may make it larger.
const AIM: f64 = 0.95;

/// But not before the samples are so many times as many: each look costs time and confidence.
const STEP: f64 = 1.125;

/// And not so far on that what is met until then would have allowed to stop long before.
const LEAP: f64 = 4.0;

/// Where nothing else ends a render whose bound cannot be relied on: so many times the samples at which the limit would
/// have been called reached, and so many at least.
const CAP: (u32, u32) = (16, 4096);

/// Points of the path tracer in sets of their own come in so many.
const WHOLE: u32 = 16;

/// Looks at a render while its samples double, and between where that is worth it.
pub struct ErrorWatch<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    settings: &'a Settings,
    way: Way,
    doublings: Option<Doublings>,
    confidence: f64,
    limit: Option<f64>,
    /// Neither a number of samples nor a time ends the render.
    is_endless: bool,
    /// Samples at which the bound was below the limit for the first time, whether it could be relied on or not.
    reached: Option<u32>,
    /// The cap ended the render.
    is_capped: bool,
    /// How bright a sample can be.
    peak: OnceCell<Peak>,
    /// How often it was looked whether the limit holds.
    looks: i32,
    /// Samples before which it is not worth looking again.
    next: Option<u32>,
    log: Option<(PathBuf, File)>,
    bar: &'a Bar,
    /// What was found when the limit held.
    held: Option<Verdict>,
    /// Whether the last line of the log has an error.
    told: bool,
    /// What measuring took so far, beside rendering.
    seconds: Cell<f64>,
    /// When it has to be done, if time is limited.
    deadline: Option<Instant>,
}

/// Where more than this of a picture would have to be rendered again, no time is set aside for it.
const WORTH: f64 = 0.5;

impl<'a> ErrorWatch<'a> {
    /// The part of a limited time that is needed to measure the error of the finished picture.
    pub fn share_of_time(settings: &Settings) -> f64 {
        let again = 1.1 * replicated_share(settings.rect());
        if Way::of(settings) == Way::Replicate && again <= WORTH { again / (1.0 + again) } else { 0.0 }
    }

    /// For a render of `settings`; fails if the log cannot be written or the error limit has no meaning.
    pub fn new(
        (scene, camera, settings): (&'a Scene, &'a Camera, &'a Settings),
        options: &RenderOptions,
        bar: &'a Bar,
    ) -> Result<Self, Failure> {
        let (way, doublings) = (Way::of(settings), Doublings::new(settings));
        if options.error_limit.is_some() && (way == Way::None || doublings.is_none()) {
            let said = "the error of these points is not known while they are taken; use --pattern sobol or random, \
                        leave out --spp with stratified, and use no grid";
            return Err(Failure::Arguments(format!("--error-limit: {said}")));
        }
        let open = |path: &PathBuf| match File::create(path) {
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
            seconds: Cell::new(0.0),
            deadline: settings.limits.time.and_then(|limit| Instant::now().checked_add(limit)),
        })
    }

    /// Takes a checkpoint in; breaks when the error is small enough.
    pub fn look(&mut self, at: &Snapshot<'_>) -> ControlFlow<()> {
        let known = self.guess(at);
        self.write((at.seconds, at.spp, at.rays()), known.as_ref());
        if self.held.is_some() || self.is_capped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The error by how the picture changed; measured where it may be below the limit.
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

    /// Whether the limit holds, and when to look again if it does not.
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
            // It cannot hold, so that nothing has to be measured, and no chance to be wrong is used up.
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
        at.also_at(next);
        self.next = Some(next);
        verdict
    }

    /// The samples at which a render ends though its bound cannot be relied on.
    fn cap(&self) -> u32 {
        let reached = self.reached.filter(|_| self.is_endless);
        reached.map_or(u32::MAX, |spp| spp.saturating_mul(CAP.0).max(CAP.1))
    }

    /// An error, with what no sample has seen.
    fn judge(&self, found: Estimate, (film, tail): (&Film, &Tail), confidence: f64) -> Verdict {
        let start = Instant::now();
        let peak = self.peak.get_or_init(|| peak(self.scene, self.camera, self.settings));
        let verdict = Verdict::new(found, unseen(film, tail, peak, confidence), self.limit);
        self.seconds.set(self.seconds.get() + start.elapsed().as_secs_f64());
        verdict
    }

    /// The samples at which a bound of the next look's confidence is likely to be below the limit and reliable, when `spp`
    /// samples had the error `found` and its square falls by `rate`; whole sets of points.
    fn worth(&self, spp: u32, (found, verdict): (Estimate, &Verdict), limit: f64, rate: f64) -> u32 {
        let of = [0, 1].map(|more| self.confidence(self.looks + more));
        let more = verdict.growth(found.bound_of(of), AIM * limit, rate, LEAP).max(STEP);
        let samples = f64::from(spp) * if more.is_finite() { more } else { STEP };
        (samples as u32).checked_next_multiple_of(WHOLE).unwrap_or(u32::MAX)
    }

    /// Whoever looks again and again, and stops when a bound happens to be small, is wrong more often than each bound is.
    /// So of the chance to be wrong the first look gets half, the next one half of what is left: all together stay below
    /// it (Boole's inequality).
    fn confidence(&self, looks: i32) -> f64 {
        1.0 - (1.0 - self.confidence) * 0.5f64.powi(looks)
    }

    /// The error of a picture of `spp` samples; renders a small part of it again where that is the only way.
    fn measure(&self, film: &Film, spp: u32, allocation: Option<&Arc<SampleAllocation>>) -> Option<Estimate> {
        let start = Instant::now();
        let found = match self.way {
            Way::Within => within(film, self.confidence(self.looks)),
            Way::Replicate if self.is_whole(spp) => {
                let settings = self.settings.clone().with_path(|p| p.allocation = allocation.cloned());
                let confidence = self.confidence(self.looks);
                let deadline = self.deadline;
                let stop = || interrupt::asked() || late(deadline);
                replicate_until(self.scene, self.camera, &settings, (film, spp), confidence, &stop)
            }
            _ => None,
        };
        self.seconds.set(self.seconds.get() + start.elapsed().as_secs_f64());
        found
    }

    /// Part of the distribution tracer's points is not the picture: cells come in order.
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
            let said = format!("error: --log {}: cannot be written: {e}; the render goes on", path.display());
            self.bar.say(&said);
            self.log = None;
        }
    }

    /// The error of the finished picture, and the seconds that it took to find out. The log gets it too, if its last
    /// line has none.
    pub fn finish(mut self, outcome: &Outcome) -> Known {
        let stats = &outcome.stats;
        let measured = || self.measure(&outcome.film, stats.spp, outcome.allocation.as_ref());
        let guessed = || self.doublings.as_ref()?.estimate(self.confidence);
        let judged = || {
            let found = measured().or_else(guessed)?;
            Some(self.judge(found, (&outcome.film, &outcome.tail), self.confidence))
        };
        // Without one whole round there is nothing to measure, however long that would take.
        let found = if stats.spp > 0 { self.held.clone().or_else(judged) } else { None };
        if found.is_some() && !self.told {
            self.write((stats.seconds, stats.spp, stats.rays), found.as_ref());
        }
        let unknown = || match self.way {
            Way::None => "the error of these points is no chance: they are the same for every seed".into(),
            _ => "too few samples to know the error".into(),
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

/// Whether time is up.
fn late(deadline: Option<Instant>) -> bool {
    deadline.is_some_and(|deadline| Instant::now() >= deadline)
}
