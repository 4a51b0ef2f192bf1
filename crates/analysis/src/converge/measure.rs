//! One seed of one run: which errors does it have after which counts and seconds?

use super::reference::Reference;
use super::run::Run;
use crate::curve::{Curve, Point};
use crate::metrics::SizeMismatch;
use dapple_imaging::Image;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Progress, Snapshot, render, render_watched};
use std::ops::ControlFlow;

/// What one seed may cost.
pub struct Allowance<'a> {
    /// Wall seconds; a count is begun only if it is likely to fit.
    pub seconds: f64,
    /// The largest count, where another seed has found it; then `seconds` are not looked at.
    pub most: Option<u32>,
    /// Asked all the time; what is unfinished when it says yes is thrown away.
    pub stop: &'a (dyn Fn(&Progress) -> bool + Sync),
    /// Processor seconds of this process so far.
    pub cpu_seconds: &'a dyn Fn() -> f64,
}

/// What was found.
pub struct Measurement {
    /// Errors at growing counts.
    pub curve: Curve,
    /// The picture at the largest.
    pub picture: Option<Image>,
    /// The largest count rendered; `None` if there is none.
    pub most: Option<u32>,
    /// Whether the curve ends because a further count would be below the reference's own error.
    pub at_reference: bool,
    /// Whether it was stopped.
    pub stopped: bool,
}

/// The largest count ever begun.
const MOST: u32 = 1 << 22;

/// From here on the first n Sobol points of a longer render are those of a render of n.
const WHOLE: u32 = 16;

/// Measures seed `seed` of `run`.
pub fn measure(
    scene: &Scene,
    run: &Run,
    seed: u64,
    reference: &Reference,
    allowance: &Allowance<'_>,
) -> Result<Measurement, SizeMismatch> {
    let mut found = Found::new(reference, allowance);
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

/// One render, looked at while its count doubles. Sobol points below [`WHOLE`] are a sequence only in part: those counts
/// are rendered alone.
fn sequence(scene: &Scene, run: &Run, seed: u64, found: &mut Found<'_>) {
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
        // Counts double, so the next one ends at twice the time.
        flow(go_on && found.fits(2.0 * at.seconds))
    };
    let outcome = render_watched(scene, &run.camera, &settings, &|p| flow(!stop(&p)), &mut look);
    found.measurement.stopped = outcome.stats.stopped;
}

/// One render per count.
fn anew(scene: &Scene, run: &Run, seed: u64, found: &mut Found<'_>) {
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

/// A render of one count; whether to go on.
fn alone(scene: &Scene, run: &Run, seed: u64, count: u32, found: &mut Found<'_>) -> bool {
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

struct Found<'a> {
    reference: &'a Reference,
    floor: f64,
    allowance: &'a Allowance<'a>,
    measurement: Measurement,
    mismatch: Option<SizeMismatch>,
}

impl<'a> Found<'a> {
    fn new(reference: &'a Reference, allowance: &'a Allowance<'a>) -> Self {
        let measurement =
            Measurement { curve: Vec::new(), picture: None, most: None, at_reference: false, stopped: false };
        Self { reference, floor: reference.mse(), allowance, measurement, mismatch: None }
    }

    /// The largest count to render.
    fn most(&self) -> u32 {
        self.allowance.most.unwrap_or(MOST)
    }

    /// Whether a count that is done after `seconds` may be begun.
    fn fits(&self, seconds: f64) -> bool {
        self.allowance.most.is_some() || seconds <= self.allowance.seconds
    }

    /// Takes one count in; whether to go on.
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
