//! What a render says about its own error: while it runs, in a log, and when it is enough.

use crate::error::Failure;
use crate::options::RenderOptions;
use crate::progress::Bar;
use dapple_analysis::estimate::{Doublings, Estimate, Way, replicate};
use dapple_analysis::statistics;
use dapple_integrator::camera::Camera;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Checkpoint, Method, Outcome, Settings};
use serde_json::json;
use std::fs::File;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// No render stops for its error before it has so many samples per pixel: with fewer, rare bright ones may be unseen.
const FEWEST: u32 = 64;

/// Looks at a render while its samples double.
pub struct ErrorWatch<'a> {
    way: Way,
    doublings: Doublings,
    confidence: f64,
    limit: Option<f64>,
    log: Option<(PathBuf, File)>,
    bar: &'a Bar,
}

impl<'a> ErrorWatch<'a> {
    /// For a render of `settings`; fails if the log cannot be written or the error limit has no meaning.
    pub fn new(options: &RenderOptions, settings: &Settings, bar: &'a Bar) -> Result<Self, Failure> {
        let way = Way::of(settings);
        if options.error_limit.is_some() && way != Way::Doublings {
            let said = "the error of these points is not known while they are taken; use --pattern sobol or random, \
                        leave out --spp with stratified, and use no grid";
            return Err(Failure::Arguments(format!("--error-limit: {said}")));
        }
        let open = |path: &PathBuf| match File::create(path) {
            Ok(file) => Ok((path.clone(), file)),
            Err(e) => Err(Failure::Arguments(format!("--log {}: cannot be written: {e}", path.display()))),
        };
        Ok(Self {
            way,
            doublings: Doublings::new(settings),
            confidence: options.confidence.unwrap_or(statistics::CONFIDENCE),
            limit: options.error_limit,
            log: options.log.as_ref().map(open).transpose()?,
            bar,
        })
    }

    /// Takes a checkpoint in; breaks when the error is small enough.
    pub fn look(&mut self, at: &Checkpoint<'_>) -> ControlFlow<()> {
        let mut known = None;
        if self.way == Way::Doublings {
            self.doublings.add(at.spp, at.film().mean());
            known = self.doublings.estimate(self.confidence);
            self.bar.set_error(known.map(|e| e.error));
        }
        self.write(at, known);
        match (self.limit, known) {
            (Some(limit), Some(known)) if at.spp >= FEWEST && known.bound <= limit => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }

    fn write(&mut self, at: &Checkpoint<'_>, known: Option<Estimate>) {
        let Some((path, file)) = &mut self.log else { return };
        let line = json!({
            "seconds": at.seconds, "spp": at.spp, "rays": at.rays(),
            "error": known.map(|e| e.error), "bound": known.map(|e| e.bound),
        });
        if let Err(e) = writeln!(file, "{line}") {
            tracing::warn!("{}: {e}", path.display());
        }
    }

    /// The error of the finished picture; renders a small part of it again where that is the only way.
    pub fn finish(
        self,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        outcome: &Outcome,
    ) -> Option<Estimate> {
        let last = match self.way {
            Way::None => return None,
            // The last count may lie beyond the last doubling; errors fall on as those of independent points at least.
            Way::Doublings => self.doublings.estimate_at(outcome.stats.spp, self.confidence),
            Way::Replicate => None,
        };
        let whole = settings.samples() == Some(outcome.stats.spp);
        let sequence =
            settings.method == Method::Path && matches!(settings.pattern, Pattern::Sobol | Pattern::Random);
        if last.is_some() || !(whole || sequence) {
            return last;
        }
        let spp = if settings.method == Method::Path { Some(outcome.stats.spp) } else { settings.spp };
        let settings = Settings { spp, ..settings.clone() };
        replicate(scene, camera, &settings, &outcome.film, self.confidence)
    }
}
