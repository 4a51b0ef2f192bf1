//! Comparison with other renderers: one command line per image, timed externally or by the renderer itself.
//!
//! Each renderer has its own reference, so that differences between material models do not count as error; with
//! `--shared-reference` it is compared with the reference of dapple's runs.

mod command;
mod startup;

pub use command::External;

use super::folder::plain;
use super::session::Session;
use crate::error::Failure;
use crate::interrupt;
use command::Took;
use dapple_analysis::converge::Reference;
use dapple_analysis::curve::{Curve, Point};
use dapple_analysis::results::{ReferenceRecord, Results, RunRecord, Seed};
use dapple_integrator::imaging::Image;
use startup::{RUNS, Startup};

/// Share of a renderer's time in which its speed is measured, by images of increasing sample counts. A reference of two
/// images as long as the last of them takes as much again or more, and the curves of five seeds somewhat less.
const SIZES: f64 = 0.35;

/// Ratio of the reference's samples to those of the last point of a curve.
const AHEAD: u32 = 8;

/// Offset of the seeds of the two halves from the first seed of the runs.
const HALVES: u32 = 1_000_000;

/// A measurement: a renderer, a scene and a reference.
pub struct Task<'a> {
    pub external: &'a External,
    pub scene: &'a str,
    /// The reference of dapple's runs and its key, if all runs share it.
    pub shared: Option<(&'a Reference, &'a str)>,
    /// End of the available time, in seconds of the clock.
    pub end: f64,
}

/// The feasible sample counts, and their times.
struct Sizes {
    /// Largest sample count that was tried.
    samples: u32,
    /// Wall-clock seconds of its image, including start-up.
    cost: f64,
    startup: Startup,
    tells_cpu: bool,
}

impl Task<'_> {
    /// Measures the renderer and adds the record, or reuses that of an earlier call.
    pub fn measure(&self, session: &mut Session<'_>, old: &Results) -> Result<(), Failure> {
        let (external, scene) = (self.external, self.scene);
        let key = self.key(session);
        let same = |r: &&RunRecord| r.scene == scene && r.name == external.name && r.key == key;
        if let Some(done) = old.runs.iter().find(same) {
            let reference = old.references.iter().filter(|r| r.scene == scene && r.key == done.reference);
            if self.shared.is_none() {
                reference.for_each(|r| session.add_reference(r.clone(), &external.name));
            }
            session.results.runs.push(done.clone());
            return Ok(());
        }
        let sizes = self.sizes(session)?;
        let enough = |s: &Sizes| self.shared.is_some() || s.samples >= AHEAD;
        let Some(sizes) = sizes.filter(enough) else {
            let said = format!("{AHEAD} samples per pixel take too long for a reference; see --budget");
            session.results.left_out.push(format!("{scene}: {}: {said}", external.name));
            return Ok(());
        };
        let made;
        let (reference, reference_key) = match self.shared {
            Some((reference, key)) => (reference, key.to_string()),
            None => {
                made = self.reference(session, sizes.samples)?;
                let record = self.describe(session, sizes.samples, &made)?;
                let key = record.key.clone();
                session.add_reference(record, &external.name);
                (&made, key)
            }
        };
        let run = self.record(key, reference_key, &sizes);
        let run = self.seeds(session, run, &sizes, reference)?;
        session.results.runs.push(run);
        session.folder.write(&mut session.results)
    }

    /// Creates the record of the run before its first seed.
    fn record(&self, key: String, reference: String, sizes: &Sizes) -> RunRecord {
        let (external, startup) = (self.external, &sizes.startup);
        let tells = external.tells_time();
        RunRecord {
            scene: self.scene.into(),
            name: external.name.clone(),
            options: external.command.clone(),
            key,
            reference,
            method: "external".into(),
            varied: "spp".into(),
            most: Some((sizes.samples / AHEAD).max(1)),
            timing: startup.said(tells, sizes.tells_cpu),
            startup_seconds: (startup.is_known && !tells).then_some(startup.wall),
            startup_cpu_seconds: (startup.is_known && !sizes.tells_cpu).then_some(startup.cpu),
            ..RunRecord::default()
        }
    }

    /// Returns a key of everything that changes the measurement.
    fn key(&self, session: &Session<'_>) -> String {
        let shared = self.shared.map(|(_, key)| format!(" against {key}")).unwrap_or_default();
        format!("{} from seed {}{shared}", self.external.command, session.first_seed())
    }

    /// Finds the largest sample count, by factors of four, whose image fits the time, and the start-up time.
    fn sizes(&self, session: &Session<'_>) -> Result<Option<Sizes>, Failure> {
        let seconds = SIZES * (self.end - session.clock.elapsed());
        let draw = |spp: u32| {
            let (_, took) = self.external.render(session, self.scene, spp, session.first_seed() + HALVES)?;
            Ok::<Took, Failure>(took)
        };
        let (mut spp, mut spent, mut before) = (1, 0.0, 0.0);
        let (mut longest, mut least) = (None, Vec::new());
        while spp <= 1 << 20 && !interrupt::asked() {
            let took = draw(spp)?;
            spent += took.wall;
            longest = Some((spp, took));
            // A render that is four times as long has the same start-up: t(4n) − t(n) = 4 (t(n) − t(n/4)).
            let more = if spp == 1 { 0.0 } else { 4.0 * (took.wall - before).max(0.0) };
            before = took.wall;
            if spp == 1 {
                least.push(took);
            }
            if spent + took.wall + more > seconds {
                break;
            }
            spp *= 4;
        }
        let Some(longest) = longest.filter(|(_, took)| took.wall <= 2.0 * seconds) else { return Ok(None) };
        while least.len() < RUNS && longest.0 > 1 && !interrupt::asked() {
            least.push(draw(1)?);
        }
        let startup = Startup::of(&least, longest);
        let tells_cpu = longest.1.told_cpu.is_some();
        Ok(Some(Sizes { samples: longest.0, cost: longest.1.wall, startup, tells_cpu }))
    }

    /// Renders two halves if seeds can be given, else one image that is taken as exact.
    fn reference(&self, session: &Session<'_>, spp: u32) -> Result<Reference, Failure> {
        let half = |i: u32| {
            let seed = session.first_seed() + HALVES + i;
            Ok::<Image, Failure>(self.external.render(session, self.scene, spp, seed)?.0)
        };
        let first = half(0)?;
        if !self.external.has_seeds() {
            return Ok(Reference::Exact(first));
        }
        Ok(Reference::Halves([first, half(1)?]))
    }

    fn describe(
        &self,
        session: &Session<'_>,
        samples: u32,
        reference: &Reference,
    ) -> Result<ReferenceRecord, Failure> {
        let (mean, name) = (reference.picture().mean(), &self.external.name);
        let (kind, samples) = match reference {
            Reference::Exact(_) => (
                format!(
                    "one image by {name} at {samples} samples per pixel; its command has no {{seed}}, so the images \
                     that are compared with it may share samples with it, and their errors are then underestimated"
                ),
                0,
            ),
            Reference::Halves(_) => (format!("two halves by {name}, with different seeds"), samples),
        };
        Ok(ReferenceRecord {
            scene: self.scene.into(),
            key: format!("external {}", self.key(session)),
            name: String::new(),
            kind,
            samples,
            mse: reference.mse(),
            relative_rmse: reference.relative_rmse(),
            mean: f64::from(mean.x + mean.y + mean.z) / 3.0,
            files: session.folder.put_reference(&format!("{}-{}", plain(self.scene), plain(name)), reference),
        })
    }

    /// Measures the curves of as many seeds as time allows.
    fn seeds(
        &self,
        session: &mut Session<'_>,
        mut run: RunRecord,
        sizes: &Sizes,
        reference: &Reference,
    ) -> Result<RunRecord, Failure> {
        let seeds = if self.external.has_seeds() { session.arguments.seeds } else { 1 };
        if self.shared.is_some() {
            let left = self.end - session.clock.elapsed();
            run.most = Some(affordable(sizes, left / f64::from(seeds)));
        }
        for i in 0..seeds {
            let most = run.most.unwrap_or(1);
            if interrupt::asked() || (i > 0 && session.clock.elapsed() + curve_cost(sizes, most) > self.end) {
                let (scene, name) = (self.scene, &run.name);
                session.results.left_out.push(format!("{scene}: {name} has {i} of {seeds} seeds"));
                break;
            }
            let seed = session.first_seed() + i;
            let (points, picture) = self.curve(session, seed, most, &sizes.startup, reference)?;
            if i == 0 {
                run.size = [picture.width as u32, picture.height as u32];
                let name = format!("{}-{}", plain(self.scene), plain(&run.name));
                (run.files, run.flip) = session.folder.put_picture(&name, &picture, &reference.picture())?;
                if points.last().is_none_or(|p| p.samples < f64::from(most)) {
                    run.ends = "beyond it the error of the reference would dominate the measurement".into();
                }
            }
            run.seeds.push(Seed { seed: seed.into(), points });
        }
        Ok(run)
    }

    /// Measures errors at doubling sample counts up to `most`; returns the curve and the last image.
    fn curve(
        &self,
        session: &Session<'_>,
        seed: u32,
        most: u32,
        startup: &Startup,
        reference: &Reference,
    ) -> Result<(Curve, Image), Failure> {
        let mut points = Vec::new();
        let mut spp = 1;
        loop {
            let (picture, took) = self.external.render(session, self.scene, spp, seed)?;
            let in_run = |e| {
                Failure::Arguments(format!(
                    "--external {}: {e}; render them with the same size",
                    self.external.name
                ))
            };
            let overall = reference.compare(&picture).map_err(in_run)?.overall;
            if overall.mse >= reference.mse() {
                let (seconds, cpu_seconds) = startup.rendering(&took);
                points.push(Point {
                    samples: f64::from(spp),
                    seconds,
                    cpu_seconds,
                    mse: overall.mse,
                    relmse: overall.relmse,
                    relative_rmse: overall.relative_rmse,
                });
            }
            spp *= 2;
            if spp > most {
                return Ok((points, picture));
            }
        }
    }
}

/// Seconds of all sample counts of a curve up to `most`: rendering takes about twice that of the last, plus a start-up
/// each.
fn curve_cost(sizes: &Sizes, most: u32) -> f64 {
    let rendering = (sizes.cost - sizes.startup.wall).max(0.0);
    let counts = f64::from(most.max(1).ilog2() + 1);
    2.0 * rendering * f64::from(most) / f64::from(sizes.samples) + counts * sizes.startup.wall
}

/// Returns the largest sample count, a power of two, whose curve takes at most `seconds`.
fn affordable(sizes: &Sizes, seconds: f64) -> u32 {
    let mut most = 1;
    while most < 1 << 20 && 1.1 * curve_cost(sizes, 2 * most) <= seconds {
        most *= 2;
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_fit_the_time() {
        let startup = Startup { wall: 1.0, is_known: true, ..Startup::default() };
        let sizes = Sizes { samples: 64, cost: 2.0, startup, tells_cpu: false };
        // 64 samples: 2 s of rendering in total, and 7 start-ups.
        assert!((curve_cost(&sizes, 64) - 9.0).abs() < 1e-12);
        assert_eq!(affordable(&sizes, 10.0), 64);
        assert_eq!(affordable(&sizes, 9.8), 32);
        assert_eq!(affordable(&sizes, 0.0), 1);
    }
}
