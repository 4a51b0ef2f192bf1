//! Measurement of one seed of a run: errors at increasing sample counts and times.

use super::reference::Reference;
use super::run::Run;
use crate::curve::{Curve, Point};
use crate::metrics::SizeMismatch;
use dapple_imaging::Image;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Progress, Snapshot, render, render_watched};
use std::ops::ControlFlow;

/// The limits of one seed.
pub struct Allowance<'a> {
    /// Wall time in seconds; a sample count is started only if it is likely to fit.
    pub seconds: f64,
    /// The largest sample count, if another seed has determined it; `seconds` is then ignored.
    pub most: Option<u32>,
    /// Polled during rendering. An unfinished render is discarded once this returns true.
    pub stop: &'a (dyn Fn(&Progress) -> bool + Sync),
    /// Processor time of this process so far in seconds.
    pub cpu_seconds: &'a dyn Fn() -> f64,
}

/// The result of [`measure`].
pub struct Measurement {
    /// Errors at increasing sample counts.
    pub curve: Curve,
    /// The image at the largest sample count.
    pub picture: Option<Image>,
    /// The largest sample count rendered; `None` if there is none.
    pub most: Option<u32>,
    /// Whether the curve ends because the error at a further sample count would be below that of the reference.
    pub at_reference: bool,
    /// Whether `stop` ended the measurement.
    pub stopped: bool,
}

/// The largest sample count that is ever started.
const MOST: u32 = 1 << 22;

/// From this count on, the first n Sobol points of a longer render are those of a render of n samples.
const WHOLE: u32 = 16;

/// Measures seed `seed` of `run`.
///
/// # Errors
/// The reference and the render differ in size.
pub fn measure(
    scene: &Scene,
    run: &Run,
    seed: u64,
    reference: &Reference,
    allowance: &Allowance<'_>,
) -> Result<Measurement, SizeMismatch> {
    let mut found = Recorder::new(reference, allowance);
    if run.is_sequence() {
        sequence(scene, run, seed, &mut found);
    } else {
        anew(scene, run, seed, &mut found);
    }
    if let Some(mismatch) = found.mismatch {
        return Err(mismatch);
    }
    Ok(found.measurement)
}

/// One render, measured each time its sample count doubles. Below [`WHOLE`], prefixes of a Sobol render differ from
/// shorter renders, so that those counts are rendered separately.
fn sequence(scene: &Scene, run: &Run, seed: u64, found: &mut Recorder<'_>) {
    let first = if run.settings.pattern == Pattern::Sobol { WHOLE } else { 1 };
    let mut count = 1;
    while count < first {
        if count > found.most() || !alone(scene, run, seed, count, found) {
            return;
        }
        count *= 2;
    }
    let cpu = (found.allowance.cpu_seconds)();
    let settings = run.settings(found.most(), seed);
    let stop = found.allowance.stop;
    let mut looking = 0.0;
    let mut look = |at: &Snapshot<'_>| {
        if at.spp < first {
            return ControlFlow::Continue(());
        }
        let now = (found.allowance.cpu_seconds)();
        let go_on = found.add(at.spp, at.seconds, now - cpu - looking, at.film().mean());
        looking += (found.allowance.cpu_seconds)() - now;
        // Sample counts double, so that the next one ends at twice the time.
        flow(go_on && found.fits(2.0 * at.seconds))
    };
    let outcome = render_watched(scene, &run.camera, &settings, &|p| flow(!stop(&p)), &mut look);
    found.measurement.stopped = outcome.stats.stopped;
}

/// One render per sample count.
fn anew(scene: &Scene, run: &Run, seed: u64, found: &mut Recorder<'_>) {
    let (mut count, mut spent) = (1, 0.0);
    loop {
        if !alone(scene, run, seed, count, found) {
            return;
        }
        let seconds = found.measurement.curve.last().map_or(0.0, |p| p.seconds);
        spent += seconds;
        count *= run.growth();
        if count > found.most() || !found.fits(spent + seconds * f64::from(run.growth())) {
            return;
        }
    }
}

/// Renders one sample count. Returns whether to continue.
fn alone(scene: &Scene, run: &Run, seed: u64, count: u32, found: &mut Recorder<'_>) -> bool {
    let cpu = (found.allowance.cpu_seconds)();
    let stop = found.allowance.stop;
    let outcome = render(scene, &run.camera, &run.settings(count, seed), &|p| flow(!stop(&p)));
    if outcome.stats.stopped {
        found.measurement.stopped = true;
        return false;
    }
    let cpu = (found.allowance.cpu_seconds)() - cpu;
    found.add(count, outcome.stats.seconds, cpu, outcome.film.mean())
}

fn flow(go_on: bool) -> ControlFlow<()> {
    if go_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}

struct Recorder<'a> {
    reference: &'a Reference,
    floor: f64,
    allowance: &'a Allowance<'a>,
    measurement: Measurement,
    mismatch: Option<SizeMismatch>,
}

impl<'a> Recorder<'a> {
    fn new(reference: &'a Reference, allowance: &'a Allowance<'a>) -> Self {
        let measurement =
            Measurement { curve: Vec::new(), picture: None, most: None, at_reference: false, stopped: false };
        Self { reference, floor: reference.mse(), allowance, measurement, mismatch: None }
    }

    /// The largest sample count to render.
    fn most(&self) -> u32 {
        self.allowance.most.unwrap_or(MOST)
    }

    /// Whether a render that finishes after `seconds` may be started.
    fn fits(&self, seconds: f64) -> bool {
        self.allowance.most.is_some() || seconds <= self.allowance.seconds
    }

    /// Adds the image of one sample count. Returns whether to continue.
    fn add(&mut self, count: u32, seconds: f64, cpu_seconds: f64, picture: Image) -> bool {
        let overall = match self.reference.compare(&picture) {
            Ok(comparison) => comparison.overall,
            Err(mismatch) => {
                self.mismatch = Some(mismatch);
                return false;
            }
        };
        self.measurement.most = Some(count);
        self.measurement.picture = Some(picture);
        if overall.mse < self.floor {
            self.measurement.at_reference = true;
            return false;
        }
        self.measurement.curve.push(Point {
            samples: f64::from(count),
            seconds,
            cpu_seconds: cpu_seconds.max(0.0),
            mse: overall.mse,
            relmse: overall.relmse,
            relative_rmse: overall.relative_rmse,
        });
        true
    }
}
