//! What a render says about its own error: while it runs, in a log, and when it is enough.

use crate::error::Failure;
use crate::options::RenderOptions;
use crate::progress::Bar;
pub use dapple_analysis::estimate::Estimate;
use dapple_analysis::estimate::{Doublings, Way, replicate, within};
use dapple_analysis::statistics;
use dapple_integrator::camera::{Camera, Film};
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Checkpoint, Method, Outcome, Settings, Spread};
use serde_json::json;
use std::cell::Cell;
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

/// Looks at a render while its samples double.
pub struct ErrorWatch<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    settings: &'a Settings,
    way: Way,
    doublings: Option<Doublings>,
    confidence: f64,
    limit: Option<f64>,
    /// How often it was looked whether the limit holds.
    looks: i32,
    log: Option<(PathBuf, File)>,
    bar: &'a Bar,
    /// What was found when the limit held.
    held: Option<Estimate>,
    /// Whether the last line of the log has an error.
    told: bool,
    /// What measuring took so far, beside rendering.
    seconds: Cell<f64>,
}

impl<'a> ErrorWatch<'a> {
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
            looks: 0,
            log: options.log.as_ref().map(open).transpose()?,
            bar,
            held: None,
            told: false,
            seconds: Cell::new(0.0),
        })
    }

    /// Takes a checkpoint in; breaks when the error is small enough.
    pub fn look(&mut self, at: &Checkpoint<'_>) -> ControlFlow<()> {
        let known = self.guess(at);
        self.write((at.seconds, at.spp, at.rays()), known);
        if self.held.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The error by how the picture changed; measured where it may be below the limit.
    fn guess(&mut self, at: &Checkpoint<'_>) -> Option<Estimate> {
        let doublings = self.doublings.as_mut()?;
        let film = at.film();
        doublings.add(at.spp, film.mean());
        let guess = doublings.estimate(self.confidence)?;
        self.bar.set_error(Some(guess.error));
        let limit = self.limit.filter(|limit| at.spp >= FEWEST && guess.error <= HOPE * limit);
        let Some(limit) = limit else { return Some(guess) };
        self.looks += 1;
        let measured = self.measure(&film, at.spp, at.spread).unwrap_or(guess);
        self.held = Some(measured).filter(|e| e.bound <= limit);
        Some(measured)
    }

    /// Whoever looks again and again, and stops when a bound happens to be small, is wrong more often than each bound is.
    /// So of the chance to be wrong the first look gets half, the next one half of what is left: all together stay below
    /// it (Boole's inequality).
    fn confidence(&self) -> f64 {
        1.0 - (1.0 - self.confidence) * 0.5f64.powi(self.looks)
    }

    /// The error of a picture of `spp` samples; renders a small part of it again where that is the only way.
    fn measure(&self, film: &Film, spp: u32, spread: Option<&Arc<Spread>>) -> Option<Estimate> {
        let start = Instant::now();
        let found = match self.way {
            Way::None => None,
            Way::Within => within(film, self.confidence()),
            Way::Replicate => {
                let settings = Settings { spread: spread.cloned(), ..self.repeatable(spp)? };
                replicate(self.scene, self.camera, &settings, film, self.confidence())
            }
        };
        self.seconds.set(self.seconds.get() + start.elapsed().as_secs_f64());
        found
    }

    /// Settings that render `spp` samples of the same kind; `None` where no render of other sets stops at so many.
    fn repeatable(&self, spp: u32) -> Option<Settings> {
        let settings = self.settings.clone();
        match settings.samples() {
            _ if settings.method == Method::Path && settings.pattern == Pattern::Sobol => {
                Some(Settings { spp: Some(spp), ..settings })
            }
            Some(whole) => (whole == spp).then_some(settings),
            // Repeated sets are looked at when their number has doubled.
            None => {
                let sets = spp / settings.round();
                (sets.is_power_of_two() && spp.is_multiple_of(settings.round())).then_some(settings)
            }
        }
    }

    fn write(&mut self, (seconds, spp, rays): (f64, u32, u64), known: Option<Estimate>) {
        let Some((path, file)) = &mut self.log else { return };
        self.told = known.is_some();
        let (error, bound) = (known.map(|e| e.error), known.map(|e| e.bound));
        let line = json!({ "seconds": seconds, "spp": spp, "rays": rays, "error": error, "bound": bound });
        if let Err(e) = writeln!(file, "{line}") {
            tracing::warn!("{}: {e}", path.display());
        }
    }

    /// The error of the finished picture, and the seconds that it took to find out. The log gets it too, if its last
    /// line has none.
    pub fn finish(mut self, outcome: &Outcome) -> (Option<Estimate>, f64) {
        let stats = &outcome.stats;
        let measured = || self.measure(&outcome.film, stats.spp, outcome.spread.as_ref());
        let guessed = || self.doublings.as_ref()?.estimate(self.confidence);
        let found = self.held.or_else(measured).or_else(guessed);
        if found.is_some() && !self.told {
            self.write((stats.seconds, stats.spp, stats.rays), found);
        }
        (found, self.seconds.get())
    }
}
