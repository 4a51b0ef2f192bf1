//! `dapple sheet`: one effect with several counts and estimators side by side, each with what it took and how wrong it is.
//!
//! All cells are rendered by the distribution tracer. So that the varied effect is all there is to see, every other effect
//! that no option mentions is off, its ideal limit (pixel centres, a pinhole, point lights, mirrors …); but varied
//! reflections and refractions keep the lights' default points, for a light that is one point cannot be seen in them. The
//! reference has the same effects off, so that the error is the varied effect's.

use crate::args::study::SheetArgs;
use crate::commands::render;
use crate::error::Failure;
use crate::load::{self, Loaded, Source};
use crate::options::RenderOptions;
use crate::progress::Bar;
use crate::values::Size;
use crate::{effects, report, settings_file};
use clap::ArgMatches;
use dapple_analysis::metrics::{self, Scale};
use dapple_integrator::imaging::sheet::{self, Cell, Frame};
use dapple_integrator::imaging::{Picture, read, write};
use dapple_integrator::sampling::plan::MAX_COUNT;
use dapple_integrator::sampling::{Pattern, Plan};
use dapple_integrator::scene::NamedCamera;
use dapple_integrator::{Combine, Effect, Method, Outcome, Settings, forecast};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Height of a cell whose size was not given.
const HEIGHT: u32 = 256;

/// The reference takes this many times the samples of the cell with the most, within these bounds.
const REFERENCE_FACTOR: u64 = 16;
const REFERENCE_SAMPLES: (u64, u64) = (256, 1 << 16);

/// Points over lights and environment for each of a varied integral over directions.
const FINER: u32 = 4;

/// Renders all cells and writes the sheet.
pub fn run(arguments: &SheetArgs, typed: &ArgMatches) -> Result<(), Failure> {
    let source = Source::new(Some(&arguments.scene));
    let options = settings_file::layered(source.path(), typed)?;
    report::start(&options);
    let output = output(typed)?;
    let given = arguments.reference.as_deref().map(read::picture).transpose()?;
    let loaded = load::load(&source, &options)?;
    let view = load::camera(&loaded.scene, &options)?;
    render::warn(&loaded);
    let asked = options.clone();
    let options = common(options, arguments.vary, &view, given.as_ref());
    let sheet = Sheet { arguments, asked, options, loaded, view };
    let plans = sheet.checked()?;
    let reference = match given {
        Some(picture) => sheet.fitting(picture)?,
        None => sheet.reference(&plans),
    };
    let cells = plans.iter().map(|cell| sheet.render(cell, &reference)).collect::<Result<Vec<_>, _>>()?;
    sheet.write(&output, &cells)?;
    if RenderOptions::is(sheet.options.json) {
        report::json(&sheet.json(&output, &reference.said, &cells));
    } else {
        report::result(&output.display().to_string());
    }
    Ok(())
}

/// The one PNG that was typed.
fn output(typed: &ArgMatches) -> Result<PathBuf, Failure> {
    let mut said = RenderOptions::default();
    said.lay_matches(typed)?;
    let path = match said.output.as_deref() {
        None => PathBuf::from("sheet.png"),
        Some([path]) => path.clone(),
        Some(_) => return Err(Failure::Arguments("-o: a sheet is one picture; name one .png".into())),
    };
    match write::Format::of(&path) {
        Ok(write::Format::Png) => write::check(&path)?,
        Ok(_) => return Err(Failure::Arguments(format!("{}: a sheet is a .png", path.display()))),
        Err(error) => return Err(error.into()),
    }
    Ok(path)
}

/// What all cells have in common: the distribution tracer, every effect that no option mentions off, small pictures.
fn common(
    mut options: RenderOptions,
    vary: Effect,
    view: &NamedCamera,
    reference: Option<&Picture>,
) -> RenderOptions {
    if options.method == Some(Method::Path) {
        report::say("note: --method path is left out: a sheet is rendered by the distribution tracer");
    }
    if options.time_limit.take().is_some() {
        report::say("note: --time-limit is left out: every cell takes all of its points");
    }
    options.method = Some(Method::Distribution);
    options.aov = None;
    // The two tracers have different defaults.
    options.max_bounces = options.max_bounces.or(Some(effects::DISTRIBUTION_BOUNCES));
    let paired = options.effects.combine == Some(Combine::Paired);
    let blurred = matches!(vary, Effect::Glossy | Effect::Refract);
    for (effect, _) in Effect::ALL {
        let keeps = paired
            || (effect == Effect::Light && blurred)
            || (effect == Effect::Pixel && options.spp.is_some());
        if effect != vary && !keeps {
            options.effects.plan_mut(effect).get_or_insert(Plan::OFF);
        }
    }
    let size = match reference {
        Some(picture) if options.crop.is_none() => {
            Size { width: picture.width as u32, height: picture.height as u32 }
        }
        _ => load::default_size(view, HEIGHT),
    };
    options.size.get_or_insert(size);
    options
}

/// What is to be rendered.
struct Sheet<'a> {
    arguments: &'a SheetArgs,
    /// As they were given.
    asked: RenderOptions,
    /// As all cells have them.
    options: RenderOptions,
    loaded: Loaded,
    view: NamedCamera,
}

/// One cell before it is rendered.
struct Planned {
    count: u32,
    pattern: Pattern,
    settings: Settings,
}

/// One cell of the sheet.
struct Rendered {
    count: u32,
    pattern: Pattern,
    frame: Frame,
    rays: u64,
    seconds: f64,
    error: f64,
}

/// Where the errors are measured from.
struct Reference {
    picture: Picture,
    /// How it came to be.
    said: String,
}

impl Sheet<'_> {
    /// The cells row by row, once it is clear that they can be rendered and make a sheet.
    fn checked(&self) -> Result<Vec<Planned>, Failure> {
        let (scene, camera, vary) = (&self.loaded.scene, &self.view.camera, self.arguments.vary);
        let plans = self.plans()?;
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
                "--size: {} cells of that size make a sheet of more than {pixels} pixels; make them smaller",
                plans.len()
            )));
        }
        effects::note_idle(&self.asked, &largest.settings, scene, camera);
        effects::confirm(&self.options, &largest.settings, scene, camera)?;
        Ok(plans)
    }

    fn plans(&self) -> Result<Vec<Planned>, Failure> {
        let of = |pattern: Pattern, count: u32| {
            let mut options = self.options.clone();
            *options.effects.plan_mut(self.arguments.vary) = Some(Plan::new(count, pattern));
            if options.effects.combine == Some(Combine::Paired) {
                for (effect, _) in Effect::ALL {
                    options.effects.plan_mut(effect).get_or_insert(Plan::new(1, pattern));
                }
            }
            let mut settings = render::settings(&options, &self.view)?;
            self.refine(&mut settings, count);
            Ok(Planned { count, pattern, settings })
        };
        let rows = self.arguments.estimators.iter();
        rows.flat_map(|&pattern| self.arguments.counts.iter().map(move |&n| of(pattern, n))).collect()
    }

    /// Beside an integral over directions of `count` points, lights and environment that no option mentions get so many that
    /// their error falls as fast as the varied integral's, and stays below it.
    fn refine(&self, settings: &mut Settings, count: u32) {
        let inner = matches!(self.arguments.vary, Effect::Glossy | Effect::Refract | Effect::Diffuse);
        let asked = self.asked.effects.light.is_some();
        if !inner || asked || settings.combine == Combine::Paired {
            return;
        }
        let more = count.saturating_mul(FINER).min(MAX_COUNT);
        let finer = |plan: Plan| Plan::new(plan.count().max(more), plan.pattern);
        settings.sky = finer(settings.sky);
        if !settings.plans.is_off(Effect::Light) {
            settings.plans.light = finer(settings.plans.light);
        }
    }

    /// Rays per pixel of a cell.
    fn rays(&self, cell: &Planned) -> f64 {
        forecast(&self.loaded.scene, &self.view.camera, &cell.settings).total()
    }

    /// The reference that was given, if it has the size of the cells.
    fn fitting(&self, picture: Picture) -> Result<Reference, Failure> {
        let file = self.arguments.reference.as_deref().unwrap_or(Path::new(""));
        let rect = render::settings(&self.options, &self.view)?.rect();
        let (width, height) = (rect.width() as usize, rect.height() as usize);
        if (picture.width, picture.height) != (width, height) {
            return Err(Failure::Arguments(format!(
                "{}: the reference has {}x{} pixels and the cells have {width}x{height}",
                file.display(),
                picture.width,
                picture.height
            )));
        }
        Ok(Reference { picture, said: file.display().to_string() })
    }

    /// A reference by the other tracer.
    fn reference(&self, plans: &[Planned]) -> Reference {
        let most = plans.iter().map(|cell| self.samples(cell)).max().unwrap_or(1);
        let (low, high) = REFERENCE_SAMPLES;
        let spp = most.saturating_mul(REFERENCE_FACTOR).clamp(low, high) as u32;
        let said = format!("path tracer, {spp} samples per pixel");
        self.say(&format!("reference: {said}"));
        let mut settings = plans[0].settings.clone();
        (settings.method, settings.spp, settings.pattern) = (Method::Path, Some(spp), Pattern::Sobol);
        let outcome = self.draw(&settings);
        Reference { picture: outcome.film.mean(), said }
    }

    fn draw(&self, settings: &Settings) -> Outcome {
        let bar = Bar::new(RenderOptions::is(self.options.quiet));
        let outcome =
            dapple_integrator::render(&self.loaded.scene, &self.view.camera, settings, &|progress| {
                bar.show(&progress);
                ControlFlow::Continue(())
            });
        bar.finish();
        outcome
    }

    /// Points per pixel at which the varied integral is looked at.
    fn samples(&self, cell: &Planned) -> u64 {
        let outer = forecast(&self.loaded.scene, &self.view.camera, &cell.settings).outer;
        let inner = match self.arguments.vary {
            Effect::Pixel | Effect::Lens | Effect::Time => 1,
            _ => cell.count,
        };
        outer.into_iter().chain([inner]).map(u64::from).fold(1, u64::saturating_mul)
    }

    fn render(&self, cell: &Planned, reference: &Reference) -> Result<Rendered, Failure> {
        let outcome = self.draw(&cell.settings);
        let picture = outcome.film.mean();
        let compared = metrics::compare(&picture, &reference.picture, &Scale::default())?;
        let (tone, exposure) =
            (self.options.tone.unwrap_or_default(), self.options.exposure.unwrap_or_default());
        let rendered = Rendered {
            count: cell.count,
            pattern: cell.pattern,
            frame: Frame::of(&picture, tone, exposure),
            rays: outcome.stats.rays,
            seconds: outcome.stats.seconds,
            error: compared.overall.relative_rmse,
        };
        self.say(&rendered.label(self.arguments.vary).replace('\n', ", "));
        Ok(rendered)
    }

    fn write(&self, path: &Path, cells: &[Rendered]) -> Result<(), Failure> {
        let labelled = cells
            .iter()
            .map(|cell| Cell { frame: cell.frame.clone(), label: cell.label(self.arguments.vary) })
            .collect::<Vec<_>>();
        let sheet = sheet::grid(&labelled, self.arguments.counts.len());
        Ok(write::rgb8(path, sheet.width, sheet.height, sheet.data)?)
    }

    fn json(&self, path: &Path, reference: &str, cells: &[Rendered]) -> Value {
        let rows = cells.iter().map(|cell| {
            json!({
                "estimator": cell.pattern.to_string(), "count": cell.count, "rays": cell.rays,
                "render_seconds": cell.seconds, "relative_rmse": cell.error,
            })
        });
        json!({
            "vary": self.arguments.vary.to_string(), "reference": reference,
            "cells": rows.collect::<Vec<_>>(), "outputs": [path.display().to_string()],
        })
    }

    fn say(&self, line: &str) {
        if !RenderOptions::is(self.options.quiet) {
            report::say(line);
        }
    }
}

impl Rendered {
    fn label(&self, vary: Effect) -> String {
        format!(
            "{vary} {}, {}\n{} rays, {:.2} s\nrelative RMSE {:.4}",
            self.count,
            self.pattern,
            short(self.rays),
            self.seconds,
            self.error
        )
    }
}

/// A count in three digits or so.
fn short(count: u64) -> String {
    match count {
        0..1000 => count.to_string(),
        1000..1_000_000 => format!("{:.1} k", count as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} M", count as f64 / 1e6),
        _ => format!("{:.1} G", count as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_short() {
        assert_eq!(
            [0, 999, 1000, 15_500_000, 2_000_000_000].map(short),
            ["0", "999", "1.0 k", "15.5 M", "2.0 G"]
        );
    }
}
