//! The table of runs and the descriptions of the references.

use super::words::{file_name, percent, two};
use crate::results::{ReferenceRecord, Results, RunRecord, TARGETS};
use maud::{Markup, html};

/// Heads of the columns before and after those of [`TARGETS`].
const FIRST: [&str; 6] = ["run", "samples", "seconds", "processor seconds", "final relative RMSE", "FLIP"];
const LAST: [&str; 3] = [
    "efficiency 1/(relMSE·s)",
    "speed-up over the first run, seconds",
    "speed-up over the first run, processor seconds",
];

/// A table with one row per run of a scene.
pub(super) fn runs(results: &Results, scene: &str) -> Markup {
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        @for head in FIRST { th { (head) } }
                        th { "squared error ∝ N" sup { "s" } ": s" }
                        @for target in TARGETS { th { "seconds to " (100.0 * target) " %" } }
                        @for head in LAST { th { (head) } }
                    }
                }
                tbody { @for run in results.of_scene(scene) { (row(run)) } }
            }
        }
    }
}

fn row(run: &RunRecord) -> Markup {
    let s = &run.summary;
    let last = |list: &[f64]| list.last().copied();
    html! {
        tr {
            td { b { (run.name) } }
            td { (last(&s.samples).map_or_else(none, |n| format!("{n:.0}"))) }
            td { (number(last(&s.seconds).filter(|t| *t > 0.0))) }
            td { (number(last(&s.cpu_seconds).filter(|t| *t > 0.0))) }
            td { (last(&s.relative_rmse).map_or_else(none, percent)) }
            td { (run.flip.map_or_else(none, |f| format!("{f:.4}"))) }
            td { (with(s.slope, s.slope_ci, two_places)) }
            @for target in TARGETS {
                @let key = target.to_string();
                @let seconds = s.seconds_to.get(&key).copied().flatten();
                td { (with(seconds, s.seconds_to_ci.get(&key).copied().flatten(), short)) }
            }
            td { (with(s.efficiency, s.efficiency_ci, short)) }
            td { (with(s.speed_up, s.speed_up_ci, |x| two(x) + "×")) }
            td { (with(s.cpu_speed_up, s.cpu_speed_up_ci, |x| two(x) + "×")) }
        }
        // The options are longer than any number, so they have a row of their own.
        tr {
            td.options colspan=(FIRST.len() + 1 + TARGETS.len() + LAST.len()) {
                small {
                    (run.options)
                    @if !run.timing.is_empty() { br; (run.timing) }
                }
            }
        }
    }
}

/// With a minus sign instead of a hyphen.
fn two_places(x: f64) -> String {
    format!("{x:.2}").replace('-', "−")
}

fn none() -> String {
    "–".into()
}

fn number(x: Option<f64>) -> String {
    x.map_or_else(none, short)
}

/// Three significant digits.
pub(super) fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        a if !(1e-3..1e5).contains(&a) => format!("{x:.2e}"),
        a if a >= 100.0 => format!("{x:.0}"),
        a if a >= 10.0 => format!("{x:.1}"),
        a if a >= 1.0 => format!("{x:.2}"),
        _ => format!("{x:.3}"),
    }
}

/// A value with its interval below it, or a note that the interval is not known.
pub(super) fn with(value: Option<f64>, ci: Option<[f64; 2]>, show: impl Fn(f64) -> String) -> Markup {
    let ci = ci
        .map_or_else(|| "interval not known".into(), |[low, high]| format!("{} … {}", show(low), show(high)));
    html! {
        @match value {
            Some(value) => { (show(value)) br; small { (ci) } },
            None => { (none()) },
        }
    }
}

/// The description of a reference in one sentence.
pub(super) fn reference(r: &ReferenceRecord) -> String {
    let (scene, name, kind) = (file_name(&r.scene), &r.name, &r.kind);
    if r.samples == 0 {
        return format!(
            "{scene}, {name}: {kind}. It is assumed to be exact: its own noise, and every systematic difference \
             between it and a run, count as errors of the runs."
        );
    }
    format!(
        "{scene}, {name}: {kind}, {} samples per pixel each. Their mean has a relative RMSE of {}; errors of runs are \
         measured without it, and curves end before they reach it.",
        r.samples,
        percent(r.relative_rmse),
    )
}
