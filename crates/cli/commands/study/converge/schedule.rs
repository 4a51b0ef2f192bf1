//! Schedule of one scene: the references, then every run, seed after seed, until the time is up.

use super::external::{External, Task};
use super::folder::plain;
use super::plan::{self, Planned};
use super::session::{Given, Session};
use crate::error::Failure;
use crate::load::{self, Loaded};
use crate::options::RenderOptions;
use crate::{interrupt, machine, memory, metering, values};
use dapple_analysis::converge::{Allowance, Measurement, Reference, allowance, apart, measure};
use dapple_analysis::results::{Difference, ReferenceRecord, Results, RunRecord, Seed};
use dapple_integrator::Settings;
use dapple_integrator::imaging::{MemoryLimit, Window, read};
use std::collections::BTreeMap;
use std::path::Path;

/// Share of a scene's time for its references.
const REFERENCE: f64 = 0.35;

/// Seeds are added while time remains, up to this multiple of the requested number.
const MOST_SEEDS: u32 = 4;

/// Measures the runs and the other renderers on one scene; `rest` scenes, including this one, share the remaining time.
pub fn scene(
    session: &mut Session<'_>,
    (given, others): (Given<'_>, &[External]),
    old: &Results,
    rest: usize,
) -> Result<(), Failure> {
    let end = session.clock.elapsed() + session.clock.left() / rest as f64;
    let Given { name, source, mut options } = given;
    options.output.clone_from(&session.arguments.options.output);
    (options.spp, options.time_limit, options.seed) = (None, None, None);
    session.memory_limit = options.memory_limit;
    let loaded = load::load(&source, &options)?;
    let planned = plan::runs(session.arguments, &options, &loaded.scene)?;
    names(&planned, others)?;
    let size = planned[0].run.settings.size;
    let limit = memory::limit(options.memory_limit);
    let file = session.arguments.reference.as_deref().map(|path| from_file(path, size, limit)).transpose()?;
    expose(session, name, &options, &loaded, &planned[0]);
    let first = session.results.runs.len();
    let shared = session.arguments.shared_reference;
    let look = |p: &Planned| if shared { planned[0].look.clone() } else { p.look.clone() };
    session.results.runs.extend(planned.iter().map(|p| record(name, p, look(p), old)));
    // Other renderers come last, each with the time of one run.
    let share = (end - session.clock.elapsed()) / (planned.len() + others.len()) as f64;
    let own_end = end - share * others.len() as f64;
    let mut scene = SceneRuns { name, loaded: &loaded, planned: &planned, file, first, end: own_end };
    let references = scene.references(session, old)?;
    scene.rounds(session, &references)?;
    scene.note_left_out(session);
    let shared = references.get(&planned[0].look).filter(|_| shared).map(|r| (r, planned[0].look.as_str()));
    for (i, external) in others.iter().enumerate() {
        if session.arguments.shared_reference && shared.is_none() {
            break;
        }
        let left = (end - session.clock.elapsed()) / (others.len() - i) as f64;
        let end = session.clock.elapsed() + left;
        Task { external, scene: name, shared, end }.measure(session, old)?;
    }
    session.results.differences.extend(differences(session, name));
    Ok(())
}

/// Sets one exposure for all PNGs of the scene, whichever run made the image, so that errors are comparable.
fn expose(session: &mut Session<'_>, name: &str, options: &RenderOptions, loaded: &Loaded, first: &Planned) {
    let what = (&loaded.scene, &first.run.camera, &first.run.settings);
    let stops = metering::for_all(&format!("the PNGs of {name}"), options, what);
    session.folder.expose(options.tone.unwrap_or_default(), stops);
}

/// Fails if the name of a renderer equals that of a run, of another renderer, or of a reference.
fn names(planned: &[Planned], externals: &[External]) -> Result<(), Failure> {
    for (i, external) in externals.iter().enumerate() {
        let name = &external.name;
        let wrong = |why: &str| Err(Failure::Arguments(format!("--external {name}: {why}")));
        let runs = planned.iter().map(|p| &p.run.name);
        if runs.chain(externals[..i].iter().map(|e| &e.name)).any(|other| plain(other) == plain(name)) {
            return wrong("the name is used twice");
        }
        if name.starts_with("reference") {
            return wrong("the name is reserved for images of references; use another name");
        }
    }
    Ok(())
}

/// Reads the image of `--reference`, which must be complete and as large as those of the runs.
fn from_file(path: &Path, size: (u32, u32), limit: MemoryLimit) -> Result<Reference, Failure> {
    let picture = read::windowed_within(path, limit)?;
    let (w, h) = picture.full_size;
    if (w, h) != (size.0 as usize, size.1 as usize) {
        return Err(Failure::Arguments(format!(
            "{}: the reference has {w}x{h} pixels, the runs {}x{}; see --size",
            path.display(),
            size.0,
            size.1
        )));
    }
    let whole = picture.covering(Window::full((w, h)), &path.display().to_string())?;
    Ok(Reference::Exact(whole))
}

/// Measures the differences of the further references of a scene from the first.
fn differences(session: &Session<'_>, scene: &str) -> Vec<Difference> {
    let records: Vec<&ReferenceRecord> =
        session.results.references.iter().filter(|r| r.scene == scene).collect();
    let Some((first, others)) = records.split_first() else { return Vec::new() };
    let Some(a) = session.kept(first).filter(|_| !others.is_empty()) else { return Vec::new() };
    let one = |record: &&ReferenceRecord| {
        let b = session.kept(record)?;
        let names = [first.name.clone(), record.name.clone()];
        let found = apart(&a, &b).ok();
        Some(Difference {
            scene: scene.into(),
            names,
            relative_rmse: found.map(|f| f.mse.max(0.0).sqrt() / first.mean),
            noise: found.map_or(0.0, |f| f.noise.sqrt() / first.mean),
            beyond_noise: found.filter(|f| f.noise_is_known).map(|f| f.is_sure()),
        })
    };
    others.iter().filter_map(one).collect()
}

/// Creates the record of a run, or continues that of an earlier call.
fn record(scene: &str, planned: &Planned, look: String, old: &Results) -> RunRecord {
    let same = |r: &&RunRecord| r.scene == scene && r.key == planned.key && r.name == planned.run.name;
    if let Some(old) = old.runs.iter().find(same) {
        return old.clone();
    }
    let run = &planned.run;
    RunRecord {
        scene: scene.into(),
        name: run.name.clone(),
        options: planned.text.clone(),
        key: planned.key.clone(),
        reference: look,
        method: values::method_name(run.settings.kind()).into(),
        pattern: run.pattern().to_string(),
        varied: run.varied(),
        size: [run.settings.size.0, run.settings.size.1],
        ..RunRecord::default()
    }
}

struct SceneRuns<'a> {
    name: &'a str,
    loaded: &'a Loaded,
    planned: &'a [Planned],
    /// The image of `--reference`.
    file: Option<Reference>,
    /// Index of the first record of its runs.
    first: usize,
    /// End of the available time, in seconds of the clock.
    end: f64,
}

impl SceneRuns<'_> {
    fn left(&self, session: &Session<'_>) -> f64 {
        self.end - session.clock.elapsed()
    }

    /// Returns a reference for every expected image: the file, those of an earlier call, or new ones.
    fn references(
        &mut self,
        session: &mut Session<'_>,
        old: &Results,
    ) -> Result<BTreeMap<String, Reference>, Failure> {
        let shared = session.arguments.shared_reference;
        let mut looks: Vec<&Planned> = Vec::new();
        for planned in self.planned {
            if (looks.is_empty() || !shared) && looks.iter().all(|p| p.look != planned.look) {
                looks.push(planned);
            }
        }
        let mut references = BTreeMap::new();
        let seconds = REFERENCE * self.left(session) / looks.len() as f64;
        for (i, planned) in looks.iter().enumerate() {
            let made = self.reference(session, planned, old, i, seconds)?;
            let Some((reference, record)) = made else { break };
            session.add_reference(record, &planned.run.name);
            references.insert(planned.look.clone(), reference);
        }
        if let Some(one) = references.values().next().filter(|_| shared).cloned() {
            references.extend(self.planned.iter().map(|p| (p.look.clone(), one.clone())));
        }
        Ok(references)
    }

    fn reference(
        &self,
        session: &Session<'_>,
        planned: &Planned,
        old: &Results,
        index: usize,
        seconds: f64,
    ) -> Result<Option<(Reference, ReferenceRecord)>, Failure> {
        let number = if index == 0 { String::new() } else { format!("-{}", index + 1) };
        let name = plain(self.name) + &number;
        if let (Some(path), Some(reference)) = (&session.arguments.reference, self.file.clone()) {
            let files = session.folder.put_reference(&name, &reference);
            let record = self.describe(planned, &reference, path.display().to_string(), 0, files);
            return Ok(Some((reference, record)));
        }
        let same = |r: &&ReferenceRecord| r.scene == self.name && r.key == planned.look && r.samples > 0;
        if let Some(record) = old.references.iter().find(same)
            && let Some(reference) = session.kept(record)
        {
            return Ok(Some((reference, record.clone())));
        }
        let (scene, run) = (&self.loaded.scene, &planned.run);
        let stop = |p: &dapple_integrator::Progress| {
            let what = format!("{}: reference · {} spp", self.name, p.spp);
            session.bar.show_task(session.clock.fraction(), session.clock.elapsed(), &what);
            interrupt::asked()
        };
        let settings = Settings { seed: session.first_seed().into(), ..run.settings.clone() };
        let Some((reference, spp)) = Reference::render(scene, &run.camera, &settings, seconds, &stop) else {
            return Ok(None);
        };
        let files = session.folder.put_reference(&name, &reference);
        let record = self.describe(
            planned,
            &reference,
            "two independent halves by dapple's path tracer with Sobol samples".into(),
            spp,
            files,
        );
        Ok(Some((reference, record)))
    }

    fn describe(
        &self,
        planned: &Planned,
        reference: &Reference,
        kind: String,
        samples: u32,
        files: Vec<String>,
    ) -> ReferenceRecord {
        let mean = reference.picture().mean();
        ReferenceRecord {
            scene: self.name.into(),
            key: planned.look.clone(),
            name: String::new(),
            kind,
            samples,
            mse: reference.mse(),
            relative_rmse: reference.relative_rmse(),
            mean: f64::from(mean.x + mean.y + mean.z) / 3.0,
            files,
        }
    }

    /// Renders seed after seed, every run once in each; writes the report page after each round.
    fn rounds(
        &mut self,
        session: &mut Session<'_>,
        references: &BTreeMap<String, Reference>,
    ) -> Result<(), Failure> {
        let seeds = session.arguments.seeds;
        for round in 1..=seeds * MOST_SEEDS {
            let mut rendered = false;
            for (i, planned) in self.planned.iter().enumerate() {
                let Some(reference) = references.get(&planned.look) else { continue };
                let records = &session.results.runs;
                let seed = session.first_seed() + round - 1;
                if records[self.first + i].seeds.iter().any(|s| s.seed == u64::from(seed)) {
                    continue;
                }
                if interrupt::asked() || !self.fits(session, i) {
                    return self.page(session);
                }
                rendered = true;
                if !self.seed(session, i, seed, reference)? {
                    return self.page(session);
                }
            }
            if rendered {
                self.page(session)?;
            }
        }
        Ok(())
    }

    fn page(&self, session: &mut Session<'_>) -> Result<(), Failure> {
        session.folder.write_page(&mut session.results)
    }

    /// Returns the seconds that one seed of a run takes; `None` before its first.
    fn cost(&self, session: &Session<'_>, i: usize) -> Option<f64> {
        let seed = session.results.runs[self.first + i].seeds.first()?;
        let seconds = seed.points.iter().map(|p| p.seconds);
        let once = self.planned[i].run.is_sequence();
        Some(if once { seconds.fold(0.0, f64::max) } else { seconds.sum() })
    }

    /// Whether one more seed of run `i` fits into the remaining time.
    fn fits(&self, session: &Session<'_>, i: usize) -> bool {
        let left = self.left(session);
        left > 0.0 && self.cost(session, i).is_none_or(|cost| 1.1 * cost <= left)
    }

    /// Renders and records one seed of run `i`; returns false if it was stopped.
    fn seed(
        &self,
        session: &mut Session<'_>,
        i: usize,
        seed: u32,
        reference: &Reference,
    ) -> Result<bool, Failure> {
        let seeds = session.arguments.seeds as usize;
        let costs: Vec<Option<f64>> = (0..self.planned.len()).map(|i| self.cost(session, i)).collect();
        let sized: Vec<f64> = costs.iter().flatten().copied().collect();
        let seconds = allowance(self.left(session), &sized, costs.len() - sized.len(), seeds);
        let run = &self.planned[i].run;
        let stop = |p: &dapple_integrator::Progress| {
            let what = format!("{}: {} · seed {seed} · {} spp", self.name, run.name, p.spp);
            session.bar.show_task(session.clock.fraction(), session.clock.elapsed(), &what);
            interrupt::asked() || !session.clock.has(0.0)
        };
        let most = session.results.runs[self.first + i].most;
        let granted = Allowance { seconds, most, stop: &stop, cpu_seconds: &machine::cpu_seconds };
        let found = measure(&self.loaded.scene, run, seed.into(), reference, &granted)?;
        // The seed that determines the sample counts may be cut short; later ones would be incomplete.
        if found.curve.is_empty() || (found.stopped && most.is_some()) {
            return Ok(false);
        }
        self.put(session, i, seed, reference, found)?;
        Ok(true)
    }

    fn put(
        &self,
        session: &mut Session<'_>,
        i: usize,
        seed: u32,
        reference: &Reference,
        found: Measurement,
    ) -> Result<(), Failure> {
        let record = &mut session.results.runs[self.first + i];
        if record.most.is_none() {
            record.most = found.most;
            if found.at_reference {
                record.ends = "beyond it the error of the reference would dominate the measurement".into();
            }
            if let Some(picture) = &found.picture {
                let name = format!("{}-{}", plain(self.name), plain(&record.name));
                (record.files, record.flip) =
                    session.folder.put_picture(&name, picture, &reference.picture())?;
            }
        }
        record.seeds.push(Seed { seed: seed.into(), points: found.curve });
        session.folder.write(&mut session.results)
    }

    fn note_left_out(&self, session: &mut Session<'_>) {
        let seeds = session.arguments.seeds as usize;
        let short: Vec<String> = session.results.runs[self.first..]
            .iter()
            .filter(|run| run.seeds.len() < seeds)
            .map(|run| format!("{}: {} has {} of {seeds} seeds", self.name, run.name, run.seeds.len()))
            .collect();
        session.results.left_out.extend(short);
    }
}
