//! Tables of the runs of a scene after equal times.

use super::table::{short, with};
use super::words::{percent, two};
use crate::results::{Equal, Results, RunRecord};
use maud::{Markup, html};

/// One table for wall time and one for processor time; empty if no two runs have a time in common.
pub(super) fn tables(results: &Results, scene: &str) -> Markup {
    let runs: Vec<&RunRecord> = results.of_scene(scene).collect();
    html! {
        (table(&runs, "seconds", |run| &run.summary.equal_time))
        (table(&runs, "processor seconds", |run| &run.summary.equal_cpu_time))
    }
}

fn table(runs: &[&RunRecord], unit: &str, of: impl Fn(&RunRecord) -> &Vec<Equal>) -> Markup {
    let mut times: Vec<f64> = runs.iter().flat_map(|run| of(run)).map(|e| e.seconds).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let Some(first) = runs.first().filter(|_| !times.is_empty()) else { return html! {} };
    html! {
        h3 { "After equal " (unit) }
        p.note {
            "Relative RMSE, and below it the efficiency relative to that of " b { (first.name) }
            " at the same time (the ratio of the squared errors), both with 95 % intervals over seeds."
        }
        div.wide {
            table {
                thead { tr { th { "run" } @for t in &times { th { (short(*t)) " s" } } } }
                tbody { @for run in runs { (row(run, of(run), &times)) } }
            }
        }
    }
}

fn row(run: &RunRecord, all: &[Equal], times: &[f64]) -> Markup {
    html! {
        tr.ruled {
            td { b { (run.name) } }
            @for t in times {
                td {
                    @match all.iter().find(|e| e.seconds == *t) {
                        None => "–",
                        Some(e) => {
                            (with(Some(e.relative_rmse), e.relative_rmse_ci, percent))
                            @if let Some(ratio) = e.efficiency_ratio {
                                br;
                                (with(Some(ratio), e.efficiency_ratio_ci, |x| two(x) + "×"))
                            }
                        },
                    }
                }
            }
        }
    }
}
