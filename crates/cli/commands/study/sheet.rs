//! `dapple sheet`: a contact sheet of one effect with several sample counts and estimators, with cost and error of
//! each.
//!
//! All cells are rendered by the distribution tracer. So that only the varied effect is visible, every other effect
//! that no option mentions is off, at its ideal limit (pixel centres, a pinhole, point lights, mirrors …); but varied
//! reflections and refractions keep the lights' default samples, because a point light is invisible in them. The
//! reference has the same effects off, so that the error is that of the varied effect; it consists of two halves, so
//! that its own noise does not count.

mod cell;
mod cost;
mod plan;
mod reference;

use crate::args::study::SheetArgs;
use crate::commands::render;
use crate::error::Failure;
use crate::inputs::Inputs;
use crate::load::{self, Loaded, Source};
use crate::options::RenderOptions;
use crate::output::refuse_link;
use crate::progress::Bar;
use crate::say::say;
use crate::{consent, effects, events, interrupt, memory, metering, saving, settings_file, standard_output};
use cell::{Found, Rendered, short};
use clap::ArgMatches;
use cost::Deadline;
use dapple_integrator::imaging::sheet::{self, Cell, Frame};
use dapple_integrator::imaging::{read, write};
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::NamedCamera;
use dapple_integrator::{Effect, MethodKind, Outcome, Settings, forecast};
use plan::Planned;
use reference::{Error, Given, Reference};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Exit code if time did not suffice for all cells.
const STOPPED: u8 = 3;

/// Maximum share of a limited time for the reference.
const REFERENCE_SHARE: f64 = 0.5;

/// Ratio of the reference's samples to those of the cell with the most samples, and bounds of their number.
const REFERENCE_FACTOR: u64 = 16;
const REFERENCE_SAMPLES: (u64, u64) = (256, 1 << 16);

/// Bytes per pixel of the cells: their images, and the sheet with its frames.
const CELL_BYTES: u64 = 40;

/// Renders all cells that time allows, and writes the sheet.
pub fn run(arguments: &SheetArgs, typed: &ArgMatches) -> Result<ExitCode, Failure> {
    let source = Source::new(Some(&arguments.scene));
    let mut options = settings_file::layered(source.path(), typed, "sheet")?;
    events::start(&options);
    let output = output(typed)?;
    let mut inputs = Inputs::of_render(&source, &options);
    for reference in [&arguments.reference, &arguments.reference_half].into_iter().flatten() {
        inputs.add("the reference", reference);
    }
    inputs.spare([output.as_path()])?;
    let given = Given::read(
        arguments.reference.as_deref(),
        arguments.reference_half.as_deref(),
        memory::limit(options.memory_limit),
    )?;
    let loaded = load::load(&source, &options)?;
    inputs.add_scene_files(&loaded.scene.files);
    inputs.spare([output.as_path()])?;
    let view = load::camera(&loaded.scene, &options)?;
    render::warn(&loaded);
    render::say_light_unit(&loaded, &options);
    let asked = options.clone();
    let limit = options.time_limit.take();
    let options = plan::common(options, arguments.vary, &view, given.as_ref());
    let mut sheet = Sheet { arguments, asked, options, loaded, view, exposure: 0.0 };
    let plans = sheet.checked()?;
    let reference = match given {
        Some(files) => Some(Reference::given(&files, &plans[0].settings)?),
        None => None,
    };
    interrupt::listen();
    let deadline = Deadline::new(limit);
    let what = (&sheet.loaded.scene, &sheet.view.camera, &plans[0].settings);
    sheet.exposure = metering::for_all("the sheet", &sheet.options, what);
    sheet.forecast(&plans, reference.as_ref(), &deadline);
    let reference = reference.or_else(|| sheet.reference(&plans, &deadline));
    let cells = sheet.cells(plans, reference.as_ref(), &deadline)?;
    let written = sheet.write(&output, &cells);
    if RenderOptions::is(sheet.options.json) {
        standard_output::json(&sheet.json(written.as_deref(), reference.as_ref(), &cells));
    } else {
        written.iter().for_each(|path| standard_output::result(&path.display().to_string()));
    }
    Ok(sheet.end(&cells, reference.is_some()))
}

/// Returns the one PNG that was typed.
fn output(typed: &ArgMatches) -> Result<PathBuf, Failure> {
    let mut said = RenderOptions::default();
    said.apply_matches(typed)?;
    let path = match said.output.as_deref() {
        None => {
            let default = PathBuf::from("sheet.png");
            refuse_link(&default)?;
            default
        }
        Some([path]) => path.clone(),
        Some(_) => return Err(Failure::Arguments("-o: a sheet is one image; name one .png".into())),
    };
    match write::Format::of(&path) {
        Ok(write::Format::Png) => write::check(&path)?,
        Ok(_) => return Err(Failure::Arguments(format!("{}: a sheet must be a .png", path.display()))),
        Err(error) => return Err(error.into()),
    }
    Ok(path)
}

/// The sheet to render.
struct Sheet<'a> {
    arguments: &'a SheetArgs,
    /// Options as they were given.
    asked: RenderOptions,
    /// Options of all cells.
    options: RenderOptions,
    loaded: Loaded,
    view: NamedCamera,
    /// Exposure of all cells, in stops.
    exposure: f32,
}

impl Sheet<'_> {
    /// Returns the cells row by row, after checking that they can be rendered and fit into a sheet.
    fn checked(&self) -> Result<Vec<Planned>, Failure> {
        let (scene, camera, vary) = (&self.loaded.scene, &self.view.camera, self.arguments.vary);
        let plans = plan::cells(self.arguments, &self.asked, &self.options, &self.view)?;
        let here = |cell: &Planned| forecast::present_in(scene, camera, &cell.settings).contains(&vary);
        if !plans.iter().all(here) {
            let remedy = match vary {
                Effect::Lens => "; see --aperture-radius",
                Effect::Time => "; see --shutter",
                _ => "",
            };
            return Err(Failure::Arguments(format!("--vary {vary}: the scene has no such effect{remedy}")));
        }
        let Some(largest) = plans.iter().max_by(|a, b| self.rays(a).total_cmp(&self.rays(b))) else {
            return Err(Failure::Arguments("--counts, --estimators: there is nothing to render".into()));
        };
        let pixels = plans.len() as u64 * largest.settings.rect().area() as u64;
        if pixels > read::MAX_PIXELS / 2 {
            return Err(Failure::Arguments(format!(
                "--size: {} cells of that size need a sheet of more than {pixels} pixels; reduce the size",
                plans.len()
            )));
        }
        let needed = pixels * CELL_BYTES;
        memory::left(self.options.memory_limit).admit(needed, None).map_err(|overrun| {
            let cells = plans.len();
            Failure::Arguments(format!("--size: a sheet of {cells} cells and {pixels} pixels {overrun}"))
        })?;
        effects::note_idle(&self.asked, &largest.settings, scene, camera);
        consent::of_rays(&self.asked, &largest.settings, scene, camera)?;
        effects::confirm(&self.options, &largest.settings, scene, camera)?;
        Ok(plans)
    }

    /// Returns the rays per pixel of a cell.
    fn rays(&self, cell: &Planned) -> f64 {
        forecast(&self.loaded.scene, &self.view.camera, &cell.settings).total()
    }

    /// Prints the expected cost of the sheet before rendering.
    fn forecast(&self, plans: &[Planned], given: Option<&Reference>, deadline: &Deadline) {
        if RenderOptions::is(self.options.quiet) {
            return;
        }
        let (scene, camera) = (&self.loaded.scene, &self.view.camera);
        let cells: Vec<&Settings> = plans.iter().map(|cell| &cell.settings).collect();
        let spp = self.reference_samples(plans);
        let reference = self.half(plans, spp);
        let wanted = given.is_none().then_some(&reference);
        let [seconds, half] = cost::seconds(scene, camera, &cells, wanted, deadline);
        let rays: f64 = cells.iter().map(|cell| cost::rays(scene, camera, cell)).sum();
        let reference = match given {
            Some(given) if given.is_exact() => {
                format!("reference {}, taken as exact: its own noise counts as error", given.said)
            }
            Some(given) => format!("reference {}", given.said),
            None => format!("its reference {}", cost::about(half.map(|s| 2.0 * s))),
        };
        let limit = deadline.seconds().map(|s| format!("; --time-limit {s} s")).unwrap_or_default();
        self.say(&format!(
            "forecast: {} cells {} (at most {} rays), {reference}{limit}",
            plans.len(),
            cost::about(seconds),
            short(rays as u64)
        ));
    }

    /// Returns the samples per pixel of both halves of the reference together.
    fn reference_samples(&self, plans: &[Planned]) -> u32 {
        let most = plans.iter().map(|cell| self.samples(cell)).max().unwrap_or(1);
        let (low, high) = REFERENCE_SAMPLES;
        most.saturating_mul(REFERENCE_FACTOR).clamp(low, high) as u32
    }

    /// Returns the settings of half of a reference of `spp` samples by the path tracer.
    fn half(&self, plans: &[Planned], spp: u32) -> Settings {
        let pattern = Pattern::Sobol;
        Settings { pattern, ..plans[0].settings.clone() }.with_method(MethodKind::Path).with_spp(spp / 2)
    }

    /// Renders a reference by the path tracer, in two halves with different seeds; with fewer samples if its share of
    /// the time ends. `None` if the time does not suffice.
    fn reference(&self, plans: &[Planned], deadline: &Deadline) -> Option<Reference> {
        let settings = self.half(plans, self.reference_samples(plans));
        let seed = |i: u64| settings.seed.wrapping_add(0xffff_ffff_0000_0001 + i);
        let share = deadline.seconds().map(|s| Duration::from_secs_f64(0.5 * REFERENCE_SHARE * s));
        let first =
            self.draw(&Settings { seed: seed(0), ..settings.clone() }.with_time_limit(share), deadline);
        let spp = first.stats.spp;
        if spp == 0 || first.stats.stopped {
            return None;
        }
        let second = self.draw(&Settings { seed: seed(1), ..settings }.with_spp(spp), deadline);
        if second.stats.stopped {
            return None;
        }
        let said = format!("path tracer, {} samples per pixel in two halves", 2 * spp);
        self.say(&format!("reference: {said}"));
        Some(Reference::of([first.film.mean(), second.film.mean()], said))
    }

    fn draw(&self, settings: &Settings, deadline: &Deadline) -> Outcome {
        let bar = Bar::new(RenderOptions::is(self.options.quiet));
        let outcome =
            dapple_integrator::render(&self.loaded.scene, &self.view.camera, settings, &|progress| {
                bar.show(&progress);
                if interrupt::asked() || deadline.is_over() {
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            });
        bar.finish();
        outcome
    }

    /// Renders all cells, the cheapest first, and returns them in the order of the sheet. A cell that would take twice
    /// the remaining time, at the speed of the one before it, is not started.
    fn cells(
        &self,
        plans: Vec<Planned>,
        reference: Option<&Reference>,
        deadline: &Deadline,
    ) -> Result<Vec<Rendered>, Failure> {
        let mut order: Vec<usize> = (0..plans.len()).collect();
        order.sort_by(|a, b| self.rays(&plans[*a]).total_cmp(&self.rays(&plans[*b])));
        let mut cells: Vec<Option<Rendered>> = plans.iter().map(|_| None).collect();
        let mut seconds_per_ray = 0.0;
        for i in order {
            let rays = self.rays(&plans[i]);
            let fits = deadline.left().is_none_or(|left| 0.5 * seconds_per_ray * rays <= left);
            let cell = self.render(&plans[i], reference, deadline, fits)?;
            seconds_per_ray = cell.found.as_ref().map_or(f64::INFINITY, |found| found.seconds / rays);
            cells[i] = Some(cell);
        }
        Ok(cells.into_iter().flatten().collect())
    }

    /// Returns the samples per pixel of the varied integral.
    fn samples(&self, cell: &Planned) -> u64 {
        let outer = forecast(&self.loaded.scene, &self.view.camera, &cell.settings).outer;
        let inner = match self.arguments.vary {
            Effect::Pixel | Effect::Lens | Effect::Time => 1,
            _ => cell.count,
        };
        outer.into_iter().chain([inner]).map(u64::from).fold(1, u64::saturating_mul)
    }

    /// Renders a cell; it is empty if it does not fit, or if time is up before it is done.
    fn render(
        &self,
        cell: &Planned,
        reference: Option<&Reference>,
        deadline: &Deadline,
        fits: bool,
    ) -> Result<Rendered, Failure> {
        let (count, pattern, rect) = (cell.count, cell.pattern, cell.settings.rect());
        let over = !fits || interrupt::asked() || deadline.is_over();
        let outcome = (!over).then(|| self.draw(&cell.settings, deadline)).filter(|o| !o.stats.stopped);
        let Some(outcome) = outcome else {
            return Ok(Rendered::empty(count, pattern, rect.width() as usize, rect.height() as usize));
        };
        let picture = outcome.film.mean();
        let error = reference.map_or(Ok(Error::Unknown), |r| r.error(&picture))?;
        let frame = Frame::of(&picture, self.options.tone.unwrap_or_default(), self.exposure);
        let found = Found { rays: outcome.stats.rays, seconds: outcome.stats.seconds, error };
        let rendered = Rendered { count, pattern, frame, found: Some(found) };
        self.say(&rendered.label(self.arguments.vary).replace('\n', ", "));
        Ok(rendered)
    }

    /// Reports what is missing.
    fn end(&self, cells: &[Rendered], has_reference: bool) -> ExitCode {
        let done = cells.iter().filter(|cell| cell.found.is_some()).count();
        if done == cells.len() && has_reference {
            return ExitCode::SUCCESS;
        }
        let errors = if has_reference { "" } else { ", no reference and no errors" };
        say(&format!("stopped early: the sheet has {done} of {} cells{errors}", cells.len()));
        ExitCode::from(STOPPED)
    }

    /// Writes the sheet; returns its path.
    fn write(&self, path: &Path, cells: &[Rendered]) -> Option<PathBuf> {
        let labelled = cells
            .iter()
            .map(|cell| Cell { frame: cell.frame.clone(), label: cell.label(self.arguments.vary) })
            .collect::<Vec<_>>();
        let sheet = sheet::grid(&labelled, self.arguments.counts.len());
        saving::save(path, |path| write::rgb8(path, sheet.width, sheet.height, sheet.data.clone()))
    }

    fn json(&self, path: Option<&Path>, reference: Option<&Reference>, cells: &[Rendered]) -> Value {
        let rows = cells.iter().map(Rendered::json);
        json!({
            "vary": self.arguments.vary.to_string(), "reference": reference.map(|r| &r.said),
            "reference_relative_rmse": reference.filter(|r| !r.is_exact()).map(Reference::relative_rmse),
            "exposure": self.exposure, "cells": rows.collect::<Vec<_>>(),
            "outputs": path.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
        })
    }

    fn say(&self, line: &str) {
        if !RenderOptions::is(self.options.quiet) {
            say(line);
        }
    }
}
