//! One image: checks everything, then loads, renders and writes, and returns the report.

use super::parting::{self, Parting};
use super::settings::settings;
use crate::checkpoint::{self, Checkpoint, State};
use crate::ending::Ending;
use crate::error::{self, Failure};
use crate::error_watch::ErrorWatch;
use crate::inputs::Inputs;
use crate::known::Known;
use crate::load::{self, Loaded, Source};
use crate::options::RenderOptions;
use crate::output::Outputs;
use crate::partial::Partial;
use crate::preflight::planned;
use crate::progress::Bar;
use crate::report::Report;
use crate::say::{say, say_lines};
use crate::{
    consent, effects, interrupt, log, metadata, metering, preflight, retrace, saving, standard_output,
    verbose,
};
use clap::ArgMatches;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::NamedCamera;
use dapple_integrator::{Advance, Outcome, Part, Renderer, Settings, Snapshot, Stats, Watcher};
use std::collections::HashSet;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::time::Instant;

/// Maximum number of bad samples whose replay command is printed.
const SHOWN: usize = 5;

/// What is kept between the images of a sequence.
#[derive(Default)]
pub struct Kept {
    /// The last scene.
    pub loaded: Option<Loaded>,
    /// Seconds for loading and building that were saved because the scene was kept.
    pub saved_seconds: f64,
    /// Decoded images of the file.
    #[cfg(feature = "gltf")]
    pub images: Option<dapple_integrator::scene::gltf::KeptImages>,
    /// Warnings and notes that were printed.
    said: HashSet<String>,
}

impl Kept {
    /// Returns the kept scene if it is the same at the time of `options`, or else loads it.
    pub fn load(&mut self, source: &Source, options: &RenderOptions) -> Result<Loaded, Failure> {
        let at = options.at.unwrap_or(0.0);
        let is_same = |kept: &Loaded| !kept.scene.is_animated || kept.scene.at == at;
        match self.loaded.take().filter(is_same) {
            Some(mut loaded) => {
                self.saved_seconds += loaded.first_seconds;
                loaded.scene.at = at;
                (loaded.load_seconds, loaded.build_seconds) = (0.0, 0.0);
                Ok(loaded)
            }
            None => load::load(source, options),
        }
    }

    /// Returns whether a message is new.
    fn is_new(&mut self, said: &str) -> bool {
        self.said.insert(said.to_string())
    }
}

/// Checks the outputs, and loads the scene; no output may replace an input.
fn opened(
    source: &Source,
    options: &RenderOptions,
    kept: &mut Kept,
) -> Result<(Outputs, checkpoint::Files, Inputs, Loaded), Failure> {
    let outputs = Outputs::plan(options, &source.name())?;
    let mut inputs = Inputs::of_render(source, options);
    let checkpoint = checkpoint::Files::open(options)?;
    inputs.spare(checkpoint.paths())?;
    parting::refuse_same(&outputs, &checkpoint)?;
    checkpoint.paths().for_each(|path| inputs.add("the checkpoint", path));
    inputs.spare(outputs.paths().chain(options.log.as_deref()))?;
    log::check(options, &outputs)?;
    let loaded = kept.load(source, options)?;
    inputs.spare(outputs.paths().chain(options.log.as_deref()))?;
    let mut scene_files = Inputs::default();
    scene_files.add_scene_files(&loaded.scene.files);
    scene_files.spare(outputs.paths().chain(options.log.as_deref()).chain(checkpoint.paths()))?;
    inputs.add_scene_files(&loaded.scene.files);
    Ok((outputs, checkpoint, inputs, loaded))
}

/// Renders one image, writes it, and returns its report and the exit code.
pub fn image(
    (scene, source): (Option<&str>, &Source),
    options: &RenderOptions,
    typed: &ArgMatches,
    kept: &mut Kept,
) -> Result<(Report, ExitCode), Failure> {
    let is_first = kept.is_new("first");
    let (mut outputs, checkpoint, inputs, loaded) = opened(source, options, kept)?;
    let view = &load::camera(&loaded.scene, options)?;
    let mut settings = settings(options, view)?;
    warn_new(&loaded, |said| kept.is_new(said));
    if is_first {
        say_light_unit(&loaded, options);
        effects::note_idle(options, &settings, &loaded.scene, &view.camera);
        say_no_picture(options);
        say_alpha(options, &settings, &outputs);
    }
    consent::of_rays(options, &settings, &loaded.scene, &view.camera)?;
    effects::confirm(options, &settings, &loaded.scene, &view.camera)?;
    preflight::check(&planned(&outputs, &checkpoint, options, &settings, 1), options)?;
    if is_first {
        interrupt::listen();
    }
    expose(&mut outputs, &loaded, view, &mut settings, options);
    let is_verbose = RenderOptions::is(options.verbose);
    if is_verbose {
        say(&verbose::render(&settings));
    }
    let part = match Parting::is_asked(options, &settings, &outputs) {
        true => Some(Parting::begin(options, &mut settings, view, &loaded, &outputs)?),
        false => None,
    };
    let lines = checkpoint_lines(options, &settings, view, &loaded);
    let (checkpoint, state) = checkpoint.begin((&loaded.scene, &settings), options, &lines)?;
    let complete = |outcome| finish(outcome, options, &loaded, view, &settings);
    let (quiet, pixels) = (RenderOptions::is(options.quiet), settings.rect().area());
    let mut partial = Partial::new(&outputs, options.long.save_every, pixels, &complete, quiet);
    partial.spare(&inputs);
    let saving = Saves { partial: &mut partial, checkpoint };
    let is_part = outputs.parts().next().is_some();
    let (outcome, known, sums) = draw(&loaded, view, &settings, options, (saving, state, is_part))?;
    let outcome = complete(outcome);
    let ending = Ending::of(options, &settings, &outcome, &known);
    if is_verbose {
        say(&verbose::writing(&outputs));
    }
    let mut written = outputs.write(&outcome, &outcome.film.mean(), ending.comment());
    if let Some(part) = part {
        let sums = (sums, ending.is_early(), options.long.has_checkpoint());
        part.end((&loaded, view, &settings), sums, (&outputs, &outcome), &mut written);
    }
    if written.failed.is_empty() {
        partial.remove();
    }
    say_bad_samples(&outcome.stats, scene, typed);
    say_failures(&outcome.stats);
    ending.line().iter().for_each(|line| say(line));
    let mut report = Report::new(&loaded, &settings, &outcome.stats, &known, (&outputs, &written));
    (report.stopped, report.unsampled_pixels) = (ending.is_early(), ending.unsampled);
    kept.loaded = Some(loaded);
    Ok((report, ending.code()))
}

/// Prints the warnings of the scene, and notes about further contents of the file.
pub fn warn(loaded: &Loaded) {
    warn_new(loaded, |_| true);
}

/// Prints the warnings of the scene and the notes that are new.
fn warn_new(loaded: &Loaded, mut is_new: impl FnMut(&str) -> bool) {
    for warning in loaded.scene.warnings.iter().filter(|warning| is_new(&warning.0)) {
        say(&format!("warning: {}", error::one_line(&warning.0)));
    }
    for note in loaded.notes.iter().filter(|note| is_new(note)) {
        say(&format!("note: {}", error::one_line(note)));
    }
}

/// Prints that intensities of lights were divided, and why.
pub fn say_light_unit(loaded: &Loaded, options: &RenderOptions) {
    let taken = loaded.scene.light_unit.as_ref().filter(|taken| taken.is_photometric);
    if let Some(taken) = taken.filter(|_| !RenderOptions::is(options.quiet)) {
        say(&format!(
            "note: intensities of lights are divided by 683 lm/W: {} (use --light-unit radiometric to leave them \
             unchanged)",
            taken.why
        ));
    }
}

/// Meters the exposure of PNG output if none is given, and prints it. Its time is taken from the time limit.
fn expose(
    outputs: &mut Outputs,
    loaded: &Loaded,
    view: &NamedCamera,
    settings: &mut Settings,
    options: &RenderOptions,
) {
    let start = Instant::now();
    let what = (&loaded.scene, &view.camera, &*settings);
    outputs.expose(|| metering::metered("the PNG", options, what));
    let left = settings.limits.time.map(|limit| limit.saturating_sub(start.elapsed()));
    *settings = settings.clone().with_time_limit(left);
}

/// What a render saves while it runs.
struct Saves<'a, 'b> {
    partial: &'a mut Partial<'b>,
    checkpoint: Option<Checkpoint>,
}

/// What observes a render: the error estimate, and what it saves.
struct Watching<'a, 'b> {
    errors: ErrorWatch<'a>,
    saves: Saves<'a, 'b>,
}

impl Watching<'_, '_> {
    /// Writes a last checkpoint.
    fn end(&mut self, renderer: &Renderer<'_>) {
        let errors = self.errors.saved();
        if self.saves.checkpoint.as_mut().is_some_and(|checkpoint| !checkpoint.save(renderer, &errors)) {
            saving::lose();
        }
    }
}

/// Returns the lines of a settings file with which a render can continue from a checkpoint.
fn checkpoint_lines(
    options: &RenderOptions,
    settings: &Settings,
    view: &NamedCamera,
    loaded: &Loaded,
) -> String {
    // The number of samples matters only if they form one set.
    let is_set = settings.pattern != Pattern::Random;
    let spp = settings.spp().filter(|_| is_set).unwrap_or_default();
    let stats = Stats { spp, ..Stats::default() };
    metadata::settings_text(options, settings, &stats, view, &loaded.scene)
}

impl Watcher for Watching<'_, '_> {
    fn look(&mut self, at: &Snapshot<'_>) -> ControlFlow<()> {
        self.errors.look(at)
    }

    fn next(&self) -> Option<u32> {
        self.errors.next()
    }

    fn between(&mut self, renderer: &Renderer<'_>) {
        let is_asked = interrupt::take_save();
        self.saves.partial.between(renderer, is_asked);
        if let Some(checkpoint) = &mut self.saves.checkpoint {
            checkpoint.between(renderer, || self.errors.saved(), is_asked);
        }
    }
}

/// Renders the image and estimates its error.
fn draw(
    loaded: &Loaded,
    view: &NamedCamera,
    settings: &Settings,
    options: &RenderOptions,
    (saves, state, is_part): (Saves<'_, '_>, Option<State>, bool),
) -> Result<(Outcome, Known, Option<Part>), Failure> {
    let bar = Bar::of(RenderOptions::is(options.quiet), options.long.progress.unwrap_or_default());
    let (scene, camera) = (&loaded.scene, &view.camera);
    let mut errors = ErrorWatch::new((scene, camera, settings), options, &bar)?;
    let timed = &in_time(settings, options);
    let progress = |progress| {
        bar.show(&progress);
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let mut due = None;
    let renderer = match state {
        None => Renderer::new(scene, camera, timed),
        Some((state, saved)) => {
            due = errors.resume(saved, state.elapsed());
            Renderer::resume(scene, camera, timed, state)
        }
    };
    let mut renderer = renderer.map_err(|e| Failure::Arguments(format!("--resume: {e}")))?;
    let mut watching = Watching { errors, saves };
    let is_enough = due.is_some_and(|due| watching.look(&renderer.snapshot().as_between(due)).is_break());
    let is_done = is_enough || watching.errors.is_done();
    let why = if is_done { Advance::Reached } else { renderer.run(&progress, &mut watching) };
    watching.end(&renderer);
    let (outcome, part) =
        if is_part { renderer.finish_with_part(why) } else { (renderer.finish_as(why), None) };
    let known = if is_part {
        Known { why: "dapple merge tells the error of the whole".into(), ..Known::default() }
    } else if tells_error(options) {
        watching.errors.finish(&outcome)
    } else {
        Known::unasked()
    };
    bar.finish();
    Ok((outcome, known, part))
}

/// Returns the settings with the part of the time limit that is for rendering: the rest is needed to measure the error.
fn in_time(settings: &Settings, options: &RenderOptions) -> Settings {
    let share = if tells_error(options) { ErrorWatch::share_of_time(settings) } else { 0.0 };
    let time_limit = settings.limits.time.map(|limit| limit.mul_f64(1.0 - share));
    settings.clone().with_time_limit(time_limit)
}

/// Whether the error is reported anywhere: estimating it takes time.
fn tells_error(options: &RenderOptions) -> bool {
    let speaks = !RenderOptions::is(options.quiet) || RenderOptions::is(options.json);
    speaks || options.log.is_some() || options.error_limit.is_some()
}

fn finish(
    mut outcome: Outcome,
    options: &RenderOptions,
    loaded: &Loaded,
    view: &NamedCamera,
    settings: &Settings,
) -> Outcome {
    let about = metadata::attributes(options, settings, &outcome.stats, view, &loaded.scene);
    outcome.layers.metadata.extend(about);
    outcome
}

fn say_no_picture(options: &RenderOptions) {
    if !options.shows_picture() && !RenderOptions::is(options.quiet) {
        let said = "only first-hit layers are requested, so the image itself is not rendered; use --aov beauty,... to \
                    render it too";
        say(&format!("note: {said}"));
    }
}

/// Prints which pixels are missing because of an error of the program.
fn say_failures(stats: &Stats) {
    for (rect, message) in &stats.failures {
        let message = error::short(message);
        say(&format!(
            "error: pixels {},{} to {},{}: internal error, please report it: {message}; they are black",
            rect.x0, rect.y0, rect.x1, rect.y1
        ));
        saving::lose();
    }
}

/// Prints that a format has no alpha, if the background is transparent.
fn say_alpha(options: &RenderOptions, settings: &Settings, outputs: &Outputs) {
    if settings.transparent && outputs.drops_alpha() && !RenderOptions::is(options.quiet) {
        say(
            "note: --transparent: the background of the .hdr is black, because the format has no alpha; write an .exr or .png for alpha",
        );
    }
}

fn say_bad_samples(stats: &Stats, scene: Option<&str>, typed: &ArgMatches) {
    if stats.bad_sample_count == 0 {
        return;
    }
    let count = stats.bad_sample_count;
    say(&format!("warning: {count} samples were not finite and count as black; to see their paths:"));
    for bad in stats.bad_samples.iter().take(SHOWN) {
        say(&format!("  {}", retrace::command(scene, (bad.x, bad.y), bad.sample, typed)));
    }
}

pub fn tell(options: &RenderOptions, told: &Report) {
    if !RenderOptions::is(options.quiet) {
        say_lines(&told.summary());
        told.bias.summary().iter().for_each(|line| say(line));
    }
    if RenderOptions::is(options.json) {
        standard_output::json(told);
    } else {
        told.outputs.iter().for_each(|path| standard_output::result(path));
    }
}
