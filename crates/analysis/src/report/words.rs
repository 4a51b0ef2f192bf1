//! What the numbers say, in plain words. Names stand in `backticks`.

use crate::results::{Results, RunRecord};

/// A few sentences about one scene: who is fastest, and what each run's error does.
pub fn summary(results: &Results, scene: &str) -> Vec<String> {
    let runs: Vec<&RunRecord> = results.of_scene(scene).filter(|run| !run.summary.mse.is_empty()).collect();
    let Some(first) = runs.first() else {
        return vec!["No run was measured: the time was too short for a single seed.".into()];
    };
    let mut said = Vec::new();
    said.extend(fastest(&runs));
    said.push(format!("`{}`: {}", first.name, falls(first)));
    for run in &runs[1..] {
        said.push(format!("`{}` {}; {}", run.name, against(run, first), falls(run)));
    }
    said
}

/// The run that needs the fewest seconds, if that is sure.
fn fastest(runs: &[&RunRecord]) -> Option<String> {
    let speed = |run: &&&RunRecord| run.summary.speed_up.unwrap_or(0.0);
    let best = runs.iter().max_by(|a, b| speed(a).total_cmp(&speed(b)))?;
    let [low, _] = best.summary.speed_up_ci?;
    (runs.len() > 1 && low > 1.0).then(|| format!("Fastest on this scene: `{}`.", best.name))
}

/// Seconds for the same error.
fn against(run: &RunRecord, first: &RunRecord) -> String {
    let s = &run.summary;
    let (Some(ratio), Some([low, high]), Some(at)) = (s.speed_up, s.speed_up_ci, s.speed_up_at) else {
        return format!("shares no error level with `{}` to be compared at", first.name);
    };
    let at = format!("for {} error", percent(at));
    let name = &first.name;
    if low > 1.0 {
        format!("needs {}× ({} to {}) fewer seconds than `{name}` {at}", two(ratio), two(low), two(high))
    } else if high < 1.0 {
        let [ratio, low, high] = [1.0 / ratio, 1.0 / high, 1.0 / low];
        format!("needs {}× ({} to {}) more seconds than `{name}` {at}", two(ratio), two(low), two(high))
    } else if high.is_finite() {
        let ratio = format!("{}× as fast, {} to {}", two(ratio), two(low), two(high));
        format!("and `{name}` need about the same seconds {at} ({ratio}: no difference is shown)")
    } else {
        format!("was rendered too few times to be compared with `{name}`")
    }
}

/// How its squared error falls.
fn falls(run: &RunRecord) -> String {
    let s = &run.summary;
    let ends =
        if run.ends.is_empty() { String::new() } else { format!(" Its curve ends early: {}.", run.ends) };
    match (s.slope, s.slope_ci) {
        (Some(slope), Some([low, high])) if high.is_finite() => {
            let [low, high] = [low, high].map(|x| format!("{x:.2}").replace('-', "−"));
            format!("its squared error falls as N^{slope:.2} ({low} to {high}).{ends}")
        }
        (Some(slope), _) => format!("its squared error falls as N^{slope:.2} (one seed).{ends}"),
        _ => format!("too few counts for a slope.{ends}"),
    }
}

/// Two significant digits, three from 10 on.
pub(super) fn two(x: f64) -> String {
    match x {
        x if x >= 100.0 => format!("{x:.0}"),
        x if x >= 1.0 => format!("{x:.1}"),
        x => format!("{x:.2}"),
    }
}

pub(super) fn percent(x: f64) -> String {
    let x = 100.0 * x;
    match x {
        x if x >= 10.0 => format!("{x:.0} %"),
        x if x >= 1.0 => format!("{x:.1} %"),
        x => format!("{x:.2} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::results;
    use super::*;

    #[test]
    fn words_say_what_the_numbers_say() {
        let said = |second, slope| summary(&results(second, slope), "box <1>").join(" ");
        let better = said(0.01, -1.5);
        assert!(better.contains("Fastest on this scene: `other`"), "{better}");
        assert!(better.contains("fewer seconds than `random`") && better.contains("N^-1.50"), "{better}");
        let worse = said(0.04, -1.0);
        assert!(worse.contains("`other` needs 4.0×") && worse.contains("more seconds"), "{worse}");
        let equal = said(0.01, -1.0);
        assert!(equal.contains("about the same seconds") && !equal.contains("Fastest"), "{equal}");
        assert!(summary(&Results::default(), "x")[0].contains("No run"));
        assert_eq!([percent(0.123), percent(0.0123), percent(0.00123)], ["12 %", "1.2 %", "0.12 %"]);
    }
}
