//! `dapple plan`: which features a render of the scene uses and omits, with reasons, and what that saves.

use super::slices::Slices;
use crate::args::PlanArgs;
use crate::commands::render;
use crate::error::Failure;
use crate::load::{self, Source};
use crate::options::RenderOptions;
use crate::values::method_name;
use crate::{effects, events, measure, settings_file, standard_output};
use clap::ArgMatches;
use dapple_integrator::plan::{Decision, RenderPlan, plan};
use serde_json::{Value, json};

/// Prints the plan; with `--measure`, also a comparison with the general plan.
pub fn run(arguments: &PlanArgs, typed: &ArgMatches) -> Result<(), Failure> {
    let source = Source::new(Some(&arguments.scene));
    let options = settings_file::layered(source.path(), typed, "plan")?;
    events::start(&options);
    let loaded = load::load(&source, &options)?;
    let view = &load::camera(&loaded.scene, &options)?;
    let settings = render::settings(&options, view)?;
    render::warn(&loaded);
    effects::note_idle(&options, &settings, &loaded.scene, &view.camera);
    if let Some(count) = arguments.slices {
        let slices = Slices::new(&options, &settings, count)?;
        match RenderOptions::is(options.json) {
            true => standard_output::json(&slices),
            false => standard_output::results(&slices.as_text()),
        }
        return Ok(());
    }
    let plan = plan(&loaded.scene, &view.camera, &settings);
    let measured = match arguments.measure {
        true => Some(measure::against_general(&source, &options)?),
        false => None,
    };
    if RenderOptions::is(options.json) {
        let mut object = as_json(&plan);
        if let Some(measured) = &measured {
            object["measured"] = json!(measured);
        }
        standard_output::json(&object);
    } else {
        standard_output::results(&as_text(&plan));
        measured.iter().for_each(|m| standard_output::results(&m.as_text()));
    }
    Ok(())
}

fn numbers(decisions: &[Decision]) -> u32 {
    decisions.iter().map(|d| d.size).sum()
}

fn list(decisions: &[Decision]) -> String {
    let names: Vec<String> = decisions.iter().map(|d| format!("{} ({})", d.name, d.size)).collect();
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

fn as_text(plan: &RenderPlan) -> String {
    let mut text = format!(
        "used\n  method      {}\n  kernel      {}\n  per camera ray {:>2} numbers: {}\n  \
         per bounce  {:>5} numbers: {}\n  lobes       {}\n  lights      {}\n  geometry    {}\n  \
         memory      {:.0} bytes per triangle, {} per pixel, scene {:.2} MB",
        method_name(plan.method),
        plan.kernel,
        numbers(&plan.camera),
        list(&plan.camera),
        numbers(&plan.bounce),
        list(&plan.bounce),
        if plan.lobes.is_empty() { "none".into() } else { plan.lobes.join(", ") },
        plan.lights,
        plan.geometry,
        plan.bytes_per_triangle,
        plan.bytes_per_pixel,
        plan.scene_bytes as f64 / 1e6,
    );
    text += "\nomitted";
    let width = plan.left_out.iter().map(|l| l.what.len()).max().unwrap_or(0);
    for left in &plan.left_out {
        text += &format!("\n  {:width$}  {}", left.what, left.why);
    }
    text
}

fn as_json(plan: &RenderPlan) -> Value {
    let decisions = |all: &[Decision]| -> Vec<Value> {
        all.iter().map(|d| json!({"name": d.name, "size": d.size})).collect()
    };
    json!({
        "method": method_name(plan.method),
        "kernel": plan.kernel,
        "camera_dimensions": decisions(&plan.camera),
        "bounce_dimensions": decisions(&plan.bounce),
        "lobes": plan.lobes,
        "lights": plan.lights,
        "geometry": plan.geometry,
        "bytes_per_triangle": plan.bytes_per_triangle,
        "bytes_per_pixel": plan.bytes_per_pixel,
        "scene_bytes": plan.scene_bytes,
        "left_out": plan.left_out.iter().map(|l| json!({"what": l.what, "why": l.why})).collect::<Vec<_>>(),
    })
}
