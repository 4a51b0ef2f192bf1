//! `dapple budget`: what makes the error of a picture, and what a given error will cost.

use crate::commands::render;
use crate::error::Failure;
use crate::load::{self, Source};
use crate::options::RenderOptions;
use crate::{report, settings_file};
use clap::ArgMatches;
use dapple_analysis::budget::{Budget, Prediction, budget};
use dapple_analysis::statistics;
use dapple_integrator::sampling::Pattern;
use std::time::Instant;

/// Prints the budget for `scene` with the sidecar's, the settings file's and the typed options.
pub fn run(scene: &str, typed: &ArgMatches) -> Result<(), Failure> {
    let source = Source::new(Some(scene));
    let options = settings_file::layered(source.path(), typed)?;
    report::start(&options);
    let Some(limit) = options.error_limit else {
        return Err(Failure::Arguments("--error-limit: say which error is wanted, such as 0.01".into()));
    };
    let loaded = load::load(&source, &options)?;
    let view = &load::camera(&loaded.scene, &options)?;
    let settings = render::settings(&options, view)?;
    if settings.pattern == Pattern::Grid {
        let said = "the error of cell centres is no chance and cannot be predicted; use --pattern sobol, stratified or random";
        return Err(Failure::Arguments(said.into()));
    }
    render::warn(&loaded);
    let start = Instant::now();
    let confidence = options.confidence.unwrap_or(statistics::CONFIDENCE);
    let found = budget(&loaded.scene, &view.camera, &settings, limit, confidence);
    let seconds = start.elapsed().as_secs_f64();
    if found.mean <= 0.0 || !found.mean.is_finite() {
        let said = "--error-limit: the pilot picture is black, and no error can be relative to it; see dapple info for lights and cameras";
        return Err(Failure::Arguments(said.into()));
    }
    if RenderOptions::is(options.json) {
        let mut object = serde_json::to_value(&found).unwrap_or_default();
        object["pilot_seconds"] = seconds.into();
        report::json(&object);
    } else {
        text(scene, &found, confidence).iter().for_each(|line| report::result(line));
        report::say(&format!("found in {seconds:.1} s"));
    }
    Ok(())
}

fn text(scene: &str, found: &Budget, confidence: f64) -> Vec<String> {
    let percent = |x: f64| format!("{:.1} %", 100.0 * x);
    let mut lines =
        vec![format!("{scene}: of the variance of one sample, with {} confidence", percent(confidence))];
    for share in &found.effects {
        let [low, high] = share.share_ci.map(percent);
        lines.push(format!("  {:<8} {:>7}   {low} … {high}", share.effect, percent(share.share)));
    }
    lines.push(format!("for a relative RMSE of {}", percent(found.error_limit)));
    lines.extend(found.predictions.iter().flat_map(prediction));
    lines
}

fn prediction(p: &Prediction) -> [String; 2] {
    let ([few, many], [low, high]) = (p.samples_ci, p.seconds_ci);
    [
        format!("  {}", p.options),
        format!(
            "      {:.0} samples ({few:.0} … {many:.0}), {:.2e} rays, {} s ({} … {})",
            p.samples,
            p.rays,
            three(p.seconds),
            three(low),
            three(high)
        ),
    ]
}

/// Three digits.
fn three(x: f64) -> String {
    if x >= 100.0 {
        format!("{x:.0}")
    } else if x >= 1.0 {
        format!("{x:.1}")
    } else {
        format!("{x:.3}")
    }
}
