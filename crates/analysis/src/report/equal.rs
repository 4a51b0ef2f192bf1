//! Tables of the errors of the runs of a scene after equal times.

use super::table::{short, with};
use super::words::{percent, two};
use crate::plot::escaped;
use crate::results::{Equal, Results, RunRecord};

/// One table for wall time and one for processor time; empty if no two runs have a time in common.
pub(super) fn tables(results: &Results, scene: &str) -> String {
    let runs: Vec<&RunRecord> = results.of_scene(scene).collect();
    let wall = table(&runs, "seconds", |run| &run.summary.equal_time);
    wall + &table(&runs, "processor seconds", |run| &run.summary.equal_cpu_time)
}

fn table(runs: &[&RunRecord], unit: &str, of: impl Fn(&RunRecord) -> &Vec<Equal>) -> String {
    let mut times: Vec<f64> = runs.iter().flat_map(|run| of(run)).map(|e| e.seconds).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let Some(first) = runs.first().filter(|_| !times.is_empty()) else { return String::new() };
    let head: String = times.iter().map(|t| format!("<th>{} s</th>", short(*t))).collect();
    let rows: String = runs.iter().map(|run| row(run, of(run), &times)).collect();
    format!(
        "<h3>After equal {unit}</h3>\n<p class=\"note\">Relative RMSE, and below it the ratio of the \
         efficiency to that of <b>{}</b> at the same time (the inverse ratio of the squared errors), both with 95 % \
         intervals over seeds.</p>\n\
         <div class=\"wide\"><table>\n<thead><tr><th>run</th>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n",
        escaped(&first.name)
    )
}

fn row(run: &RunRecord, all: &[Equal], times: &[f64]) -> String {
    let cell = |t: &f64| match all.iter().find(|e| e.seconds == *t) {
        None => "<td>–</td>".into(),
        Some(e) => {
            let error = with(Some(e.relative_rmse), e.relative_rmse_ci, percent);
            let ratio = e.efficiency_ratio.map(|r| with(Some(r), e.efficiency_ratio_ci, |x| two(x) + "×"));
            format!("<td>{error}{}</td>", ratio.map(|r| format!("<br>{r}")).unwrap_or_default())
        }
    };
    let cells: String = times.iter().map(cell).collect();
    format!("<tr class=\"ruled\"><td><b>{}</b></td>{cells}</tr>\n", escaped(&run.name))
}
