//! The table of runs and the descriptions of the references.

use super::words::{file_name, percent, two};
use crate::plot::escaped;
use crate::results::{ReferenceRecord, Results, RunRecord, TARGETS};

const HEAD: [&str; 10] = [
    "run",
    "samples",
    "seconds",
    "processor seconds",
    "final relative RMSE",
    "FLIP",
    "squared error ∝ N<sup>s</sup>: s",
    "efficiency 1/(relMSE·s)",
    "speed-up over the first run, seconds",
    "speed-up over the first run, processor seconds",
];

/// One row per run of a scene.
pub(super) fn runs(results: &Results, scene: &str) -> String {
    let mut head: Vec<String> = HEAD.iter().map(|h| h.to_string()).collect();
    head.splice(7..7, TARGETS.map(|t| format!("seconds to {} %", 100.0 * t)));
    let head: String = head.iter().map(|h| format!("<th>{h}</th>")).collect();
    let rows: String = results.of_scene(scene).map(row).collect();
    format!(
        "<div class=\"wide\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n"
    )
}

fn row(run: &RunRecord) -> String {
    let s = &run.summary;
    let last = |list: &[f64]| list.last().copied();
    let mut cells = vec![
        format!("<b>{}</b>", escaped(&run.name)),
        last(&s.samples).map_or_else(none, |n| format!("{n:.0}")),
        number(last(&s.seconds).filter(|t| *t > 0.0)),
        number(last(&s.cpu_seconds).filter(|t| *t > 0.0)),
        last(&s.relative_rmse).map_or_else(none, percent),
        run.flip.map_or_else(none, |f| format!("{f:.4}")),
        with(s.slope, s.slope_ci, two_places),
    ];
    cells.extend(TARGETS.iter().map(|t| {
        let key = t.to_string();
        let find = s.seconds_to.get(&key).copied().flatten();
        with(find, s.seconds_to_ci.get(&key).copied().flatten(), short)
    }));
    cells.push(with(s.efficiency, s.efficiency_ci, short));
    cells.push(with(s.speed_up, s.speed_up_ci, |x| two(x) + "×"));
    cells.push(with(s.cpu_speed_up, s.cpu_speed_up_ci, |x| two(x) + "×"));
    let cells: String = cells.iter().map(|c| format!("<td>{c}</td>")).collect();
    // Options are in a row of their own across all columns, because they are longer than any number.
    let timing = if run.timing.is_empty() { String::new() } else { format!("<br>{}", escaped(&run.timing)) };
    let options = format!(
        "<td class=\"options\" colspan=\"{}\"><small>{}{timing}</small></td>",
        HEAD.len() + TARGETS.len(),
        escaped(&run.options)
    );
    format!("<tr>{cells}</tr>\n<tr>{options}</tr>\n")
}

/// Two decimal places, with a minus sign instead of a hyphen.
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

/// A value with its interval underneath, or the statement that the interval is not known.
pub(super) fn with(value: Option<f64>, ci: Option<[f64; 2]>, show: impl Fn(f64) -> String) -> String {
    let Some(value) = value else { return none() };
    let ci = ci
        .map_or_else(|| "interval not known".into(), |[low, high]| format!("{} … {}", show(low), show(high)));
    format!("{}<br><small>{ci}</small>", show(value))
}

/// The description of a reference in a sentence.
pub(super) fn reference(r: &ReferenceRecord) -> String {
    let (scene, name, kind) = (escaped(file_name(&r.scene)), escaped(&r.name), escaped(&r.kind));
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
