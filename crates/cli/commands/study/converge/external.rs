//! Other renderers on the same axes: a command line per picture, timed from outside.
//!
//! Each has a reference of its own, made by itself, so that another idea of a material does not count as noise. Seconds
//! are those of the whole command, loading included.

use super::Session;
use super::folder::plain;
use crate::error::{self, Failure};
use crate::interrupt;
use dapple_analysis::converge::Reference;
use dapple_analysis::curve::{Curve, Point};
use dapple_analysis::results::{ReferenceRecord, Results, RunRecord, Seed};
use dapple_integrator::imaging::{Picture, read};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Share of its time that a renderer's reference gets.
const REFERENCE: f64 = 0.4;

/// The reference has so many times the samples of the last point of a curve.
const AHEAD: u32 = 8;

/// Seeds of the two halves.
const HALVES: [u32; 2] = [1_000_001, 1_000_002];

/// A renderer.
pub struct External {
    name: String,
    command: String,
}

impl External {
    /// `NAME=COMMAND`; the command must say where `{spp}` and `{out}` go.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        let wrong = |why: &str| Failure::Arguments(format!("--external '{text}': {why}"));
        let (name, command) = text.split_once('=').ok_or_else(|| wrong("write it as NAME=COMMAND"))?;
        for needed in ["{spp}", "{out}"] {
            if !command.contains(needed) {
                return Err(wrong(&format!("the command must contain {needed}")));
            }
        }
        Ok(Self { name: name.trim().into(), command: command.trim().into() })
    }

    fn has_seeds(&self) -> bool {
        self.command.contains("{seed}")
    }

    /// One picture and its seconds.
    fn render(
        &self,
        session: &Session<'_>,
        scene: &str,
        spp: u32,
        seed: u32,
    ) -> Result<(Picture, f64), Failure> {
        let out = session.folder.file(&format!("{}-{}.exr", plain(scene), plain(&self.name)));
        let line = self.command.replace("{scene}", scene).replace("{spp}", &spp.to_string());
        let line = line.replace("{out}", &out.display().to_string()).replace("{seed}", &seed.to_string());
        let what = format!("{scene}: {} · seed {seed} · {spp} spp", self.name);
        session.bar.show_task(session.clock.fraction(), session.clock.elapsed(), &what);
        let failed = |why: String| Failure::Arguments(format!("--external {}: `{line}` {why}", self.name));
        // A picture of an earlier call must not be taken for this one's.
        let _ = std::fs::remove_file(&out);
        let start = Instant::now();
        let done = shell(&line).stdin(Stdio::null()).stdout(Stdio::null()).output();
        let seconds = start.elapsed().as_secs_f64();
        let done = done.map_err(|e| failed(format!("cannot be started: {e}")))?;
        if !done.status.success() {
            let said = String::from_utf8_lossy(&done.stderr);
            let last = said.lines().rfind(|l| !l.trim().is_empty()).unwrap_or_default().to_string();
            return Err(failed(format!("failed ({}): {}", done.status, error::one_line(&last))));
        }
        let picture = read::picture(&out).map_err(|e| failed(format!("left no picture: {e}")))?;
        Ok((picture, seconds))
    }
}

fn shell(line: &str) -> Command {
    let (shell, option) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
    let mut command = Command::new(shell);
    command.arg(option).arg(line);
    command
}

/// Measures one renderer on one scene until second `end` of the clock; adds its record.
pub fn measure(
    session: &mut Session<'_>,
    external: &External,
    scene: &str,
    old: &Results,
    end: f64,
) -> Result<(), Failure> {
    let same = |r: &&RunRecord| r.scene == scene && r.name == external.name && r.key == external.command;
    if let Some(done) = old.runs.iter().find(same) {
        let reference = old.references.iter().filter(|r| r.scene == scene && r.key == done.reference);
        session.results.references.extend(reference.cloned());
        session.results.runs.push(done.clone());
        return Ok(());
    }
    let seconds = end - session.clock.elapsed();
    let Some((samples, cost)) = largest(session, external, scene, 0.5 * REFERENCE * seconds)? else {
        session.results.left_out.push(format!("{scene}: {}: one picture takes too long", external.name));
        return Ok(());
    };
    let reference = reference(session, external, scene, samples)?;
    let name = format!("{}-{}", plain(scene), plain(&external.name));
    let record = describe(session, external, scene, samples, &reference, &name)?;
    session.results.references.push(record);
    let mut run = RunRecord {
        scene: scene.into(),
        name: external.name.clone(),
        options: external.command.clone(),
        key: external.command.clone(),
        reference: format!("external {}", external.name),
        method: "external".into(),
        varied: "spp".into(),
        most: Some((samples / AHEAD).max(1)),
        ..RunRecord::default()
    };
    // All counts of a curve together cost about twice its last.
    let curve_cost = 2.0 * cost / f64::from(AHEAD);
    let seeds = if external.has_seeds() { session.arguments.seeds } else { 1 };
    for seed in 1..=seeds {
        if interrupt::asked() || (seed > 1 && session.clock.elapsed() + curve_cost > end) {
            let (had, name) = (seed - 1, &external.name);
            session.results.left_out.push(format!("{scene}: {name} has {had} of {seeds} seeds"));
            break;
        }
        let (points, picture) = curve(session, external, scene, seed, &run, &reference)?;
        if seed == 1 {
            run.size = [picture.width as u32, picture.height as u32];
            (run.files, run.flip) = session.folder.put_picture(&name, &picture, &reference.picture())?;
        }
        run.seeds.push(Seed { seed: seed.into(), points });
    }
    session.results.runs.push(run);
    session.folder.write(&mut session.results)
}

/// The largest count, by doubling, whose picture takes at most `seconds`, and what it takes.
fn largest(
    session: &Session<'_>,
    external: &External,
    scene: &str,
    seconds: f64,
) -> Result<Option<(u32, f64)>, Failure> {
    let (mut found, mut spp, mut spent) = (None, 1, 0.0);
    while spp <= 1 << 20 && !interrupt::asked() {
        let (_, cost) = external.render(session, scene, spp, HALVES[0])?;
        spent += cost;
        found = Some((spp, cost));
        if spent + 2.0 * cost > seconds {
            break;
        }
        spp *= 2;
    }
    Ok(found.filter(|(_, cost)| *cost <= 2.0 * seconds))
}

/// Two halves where seeds can be given, else one picture that is taken as exact.
fn reference(
    session: &Session<'_>,
    external: &External,
    scene: &str,
    spp: u32,
) -> Result<Reference, Failure> {
    let (first, _) = external.render(session, scene, spp, HALVES[0])?;
    if !external.has_seeds() {
        return Ok(Reference::Exact(first));
    }
    let (second, _) = external.render(session, scene, spp, HALVES[1])?;
    Ok(Reference::Halves([first, second]))
}

fn describe(
    session: &Session<'_>,
    external: &External,
    scene: &str,
    samples: u32,
    reference: &Reference,
    name: &str,
) -> Result<ReferenceRecord, Failure> {
    let mean = reference.picture().mean();
    let (kind, samples) = match reference {
        Reference::Exact(_) => {
            (format!("one picture of {} at {samples} samples per pixel", external.name), 0)
        }
        Reference::Halves(_) => (format!("two halves by {}", external.name), samples),
    };
    Ok(ReferenceRecord {
        scene: scene.into(),
        key: format!("external {}", external.name),
        kind,
        samples,
        mse: reference.mse(),
        relative_rmse: reference.relative_rmse(),
        mean: f64::from(mean.x + mean.y + mean.z) / 3.0,
        files: session.folder.put_reference(name, reference)?,
    })
}

/// Errors at doubling counts up to the run's largest, and the last picture.
fn curve(
    session: &Session<'_>,
    external: &External,
    scene: &str,
    seed: u32,
    run: &RunRecord,
    reference: &Reference,
) -> Result<(Curve, Picture), Failure> {
    let mut points = Vec::new();
    let mut spp = 1;
    loop {
        let (picture, seconds) = external.render(session, scene, spp, seed)?;
        let overall = reference.compare(&picture)?.overall;
        if overall.mse >= reference.mse() {
            points.push(Point {
                samples: f64::from(spp),
                seconds,
                cpu_seconds: 0.0,
                mse: overall.mse,
                relmse: overall.relmse,
                relative_rmse: overall.relative_rmse,
            });
        }
        spp *= 2;
        if spp > run.most.unwrap_or(1) {
            return Ok((points, picture));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_say_where_counts_and_pictures_go() {
        let found = External::parse("other = render {scene} -s {spp} -o {out} --seed {seed}").unwrap();
        assert_eq!((found.name.as_str(), found.has_seeds()), ("other", true));
        for bad in ["other", "other=render {spp}", "other=render {out}"] {
            assert!(External::parse(bad).is_err(), "{bad}");
        }
    }
}
