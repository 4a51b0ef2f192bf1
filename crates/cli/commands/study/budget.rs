//! `dapple budget`: the sources of an image's error, and the cost of reaching a given error.

use crate::commands::render;
use crate::error::Failure;
use crate::load::{self, Source};
use crate::options::RenderOptions;
use crate::say::say;
use crate::{events, settings_file, standard_output};
use clap::ArgMatches;
use dapple_analysis::budget::{Budget, Prediction, budget};
use dapple_analysis::statistics;
use dapple_integrator::sampling::Pattern;
use std::time::Instant;

/// Prints the budget for `scene` with the sidecar's, the settings file's and the typed options.
pub fn run(scene: &str, typed: &ArgMatches) -> Result<(), Failure> {
    let source = Source::new(Some(scene));
    let options = settings_file::layered(source.path(), typed, "budget")?;
    events::start(&options);
    let Some(limit) = options.error_limit else {
        return Err(Failure::Arguments("--error-limit: give the target error, such as 0.01".into()));
    };
    let loaded = load::load(&source, &options)?;
    let view = &load::camera(&loaded.scene, &options)?;
    let mut settings = render::settings(&options, view)?;
    // The time limit applies to the pilot, not to the image.
    let time = options.time_limit;
    settings = settings.with_time_limit(None);
    if settings.pattern == Pattern::Grid {
        let said = "the error of grid samples is not random and cannot be predicted; use --pattern sobol, stratified \
                    or random";
        return Err(Failure::Arguments(said.into()));
    }
    render::warn(&loaded);
    let start = Instant::now();
    let confidence = options.confidence.unwrap_or(statistics::CONFIDENCE);
    let found = budget(&loaded.scene, &view.camera, &settings, limit, confidence, time);
    let seconds = start.elapsed().as_secs_f64();
    if found.mean <= 0.0 || !found.mean.is_finite() {
        let said = "--error-limit: the pilot image is black, and no error can be relative to it; see dapple info for \
                    lights and cameras";
        return Err(Failure::Arguments(said.into()));
    }
    if RenderOptions::is(options.json) {
        let mut object = serde_json::to_value(&found).unwrap_or_default();
        object["pilot_seconds"] = seconds.into();
        standard_output::json(&object);
    } else {
        text(scene, &found, confidence).iter().for_each(|line| standard_output::result(line));
        if !RenderOptions::is(options.quiet) {
            say(&format!("computed in {seconds:.1} s"));
        }
    }
    Ok(())
}

fn text(scene: &str, found: &Budget, confidence: f64) -> Vec<String> {
    let percent = |x: f64| format!("{:.1} %", 100.0 * x);
    let mut lines = vec![format!(
        "{scene}: shares of the variance of one sample, with {} confidence",
        percent(confidence)
    )];
    for share in &found.effects {
        let [low, high] = share.share_ci.map(percent);
        lines.push(format!("  {:<8} {:>7}   {low} … {high}", share.effect, percent(share.share)));
    }
    lines.push(format!("for a relative RMSE of {}", percent(found.error_limit)));
    lines.extend(found.predictions.iter().flat_map(prediction));
    lines
}

fn prediction(p: &Prediction) -> [String; 2] {
    let not_known = || "interval unknown".to_string();
    let samples = p.samples_ci.map_or_else(not_known, |[few, many]| format!("{few:.0} … {many:.0}"));
    let seconds =
        p.seconds_ci.map_or_else(not_known, |[low, high]| format!("{} … {}", three(low), three(high)));
    let more = if p.is_narrow {
        ""
    } else {
        "; the pilot took too few samples for a narrow interval; see --time-limit"
    };
    [
        format!("  {}", p.options),
        format!(
            "      {:.0} samples ({samples}), {:.2e} rays, {} s ({seconds}){more}",
            p.samples,
            p.rays,
            three(p.seconds),
        ),
    ]
}

/// Formats a number with three digits.
fn three(x: f64) -> String {
    if x >= 100.0 {
        format!("{x:.0}")
    } else if x >= 1.0 {
        format!("{x:.1}")
    } else {
        format!("{x:.3}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With too few pilot samples, the interval is reported as wide or unknown.
    #[test]
    fn what_is_not_known_is_not_printed() {
        let of = |samples_ci, is_narrow| {
            let (method, options) = ("path".into(), "--spp 181".into());
            let seconds_ci = None;
            let p = Prediction {
                method,
                options,
                samples: 181.0,
                samples_ci,
                rays: 1e6,
                seconds: 1.0,
                seconds_ci,
                is_narrow,
            };
            prediction(&p).join("")
        };
        let unknown = of(None, false);
        assert!(
            unknown.contains("181 samples (interval unknown)") && unknown.contains("--time-limit"),
            "{unknown}"
        );
        let wide = of(Some([40.0, 700.0]), false);
        assert!(wide.contains("(40 … 700)") && wide.contains("--time-limit"), "{wide}");
        assert!(!of(Some([150.0, 210.0]), true).contains("--time-limit"));
    }
}
