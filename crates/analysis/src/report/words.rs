//! Summaries of the results in sentences. Names are in `backticks`.

use crate::results::{Difference, Results, RunRecord};

/// A few sentences about one scene: warnings about its references, the fastest run, and the convergence of each run.
pub fn summary(results: &Results, scene: &str) -> Vec<String> {
    let runs: Vec<&RunRecord> = results.of_scene(scene).filter(|run| !run.summary.mse.is_empty()).collect();
    let Some(first) = runs.first() else {
        return vec!["No run was measured: the time limit was too short for a single seed.".into()];
    };
    let mut said: Vec<String> =
        results.differences.iter().filter(|d| d.scene == scene).filter_map(differ).collect();
    said.extend(fastest(&runs));
    said.push(format!("`{}`: {}", first.name, falls(first)));
    for run in &runs[1..] {
        said.push(format!("`{}` {}{}; {}", run.name, against(run, first), after(run), falls(run)));
    }
    said
}

/// A warning if two references differ.
fn differ(d: &Difference) -> Option<String> {
    let [a, b] = &d.names;
    let Some(by) = d.relative_rmse else {
        return Some(format!(
            "Warning: `{a}` and `{b}` have different sizes: runs that are compared with them do not render the \
             same image."
        ));
    };
    let by = percent(by);
    match d.beyond_noise {
        Some(false) => None,
        Some(true) => Some(format!(
            "Warning: `{a}` and `{b}` differ by {by} (root of the mean squared difference without noise; their own noise is \
             {}): runs that are compared with them do not compute the same image.",
            percent(d.noise)
        )),
        None => Some(format!(
            "Warning: `{a}` and `{b}` differ by {by}; how much of that is noise is not known, because one of them is \
             a single image."
        )),
    }
}

/// The run that needs the fewest seconds for the same error, if that is certain: its interval lies above those of all
/// others.
fn fastest(runs: &[&RunRecord]) -> Option<String> {
    // The first run is compared with itself.
    let ends = |i: usize| if i == 0 { Some([1.0, 1.0]) } else { runs[i].summary.speed_up_ci };
    let all: Option<Vec<[f64; 2]>> = (0..runs.len()).map(ends).collect();
    let all = all?;
    let above = |i: usize| (0..all.len()).all(|j| i == j || all[i][0] > all[j][1]);
    let best = (0..all.len()).find(|i| above(*i))?;
    (runs.len() > 1).then(|| format!("Fastest to the same error on this scene: `{}`.", runs[best].name))
}

/// The comparison of seconds for the same error.
fn against(run: &RunRecord, first: &RunRecord) -> String {
    let s = &run.summary;
    let (Some(ratio), Some(at)) = (s.speed_up, s.speed_up_at) else {
        if s.seconds.iter().all(|seconds| *seconds == 0.0) {
            return "renders too briefly to be timed apart from its start-up, and is not compared in seconds"
                .into();
        }
        return format!("has no error level in common with `{}`, and is not compared in seconds", first.name);
    };
    let at = format!("for {} error", percent(at));
    let name = &first.name;
    let Some([low, high]) = s.speed_up_ci else {
        return format!(
            "and `{name}`: it is not known which needs fewer seconds {at} ({}× as fast by the mean of the seeds, too few \
             or too different for an interval)",
            two(ratio)
        );
    };
    if low > 1.0 {
        format!("needs {}× ({} to {}) fewer seconds than `{name}` {at}", two(ratio), two(low), two(high))
    } else if high < 1.0 {
        let [ratio, low, high] = [1.0 / ratio, 1.0 / high, 1.0 / low];
        format!("needs {}× ({} to {}) more seconds than `{name}` {at}", two(ratio), two(low), two(high))
    } else {
        let ratio = format!("{}× as fast, {} to {}", two(ratio), two(low), two(high));
        format!("and `{name}` need about the same seconds {at} ({ratio}: no significant difference)")
    }
}

/// The comparison of errors after the longest time that the run has in common with the first.
fn after(run: &RunRecord) -> String {
    let at = run.summary.equal_time.iter().find(|e| e.efficiency_ratio.is_some());
    let Some((at, ratio)) = at.and_then(|at| Some((at, at.efficiency_ratio?))) else { return String::new() };
    let interval = match at.efficiency_ratio_ci {
        Some([low, high]) => format!("{} to {}", two(low), two(high)),
        None => "interval not known".into(),
    };
    format!(", and after {} s has {}× ({interval}) the efficiency of the first", two(at.seconds), two(ratio))
}

/// The rate at which the squared error falls.
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
        _ => format!("too few sample counts for a slope.{ends}"),
    }
}

/// Two significant digits; three from 10 on.
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

/// The name of a scene without its folder.
pub(super) fn file_name(scene: &str) -> &str {
    scene.rsplit('/').next().unwrap_or(scene)
}

#[cfg(test)]
mod tests {
    use super::super::tests::results;
    use super::*;

    #[test]
    fn words_say_what_the_numbers_say() {
        let said = |second, slope| summary(&results(second, slope), "box <1>").join(" ");
        let better = said(0.01, -1.5);
        assert!(better.contains("Fastest to the same error on this scene: `other`"), "{better}");
        assert!(better.contains("fewer seconds than `random`") && better.contains("N^-1.50"), "{better}");
        let worse = said(0.04, -1.0);
        assert!(worse.contains("`other` needs 4.0×") && worse.contains("more seconds"), "{worse}");
        assert!(worse.contains("has 0.25× (0.24 to 0.26) the efficiency of the first"), "{worse}");
        assert!(worse.contains("Fastest to the same error on this scene: `random`"), "{worse}");
        let equal = said(0.01, -1.0);
        assert!(equal.contains("about the same seconds") && !equal.contains("Fastest"), "{equal}");
        assert!(summary(&Results::default(), "x")[0].contains("No run"));
        let warned = |beyond_noise, relative_rmse| {
            let names = ["reference".to_string(), "reference of x".to_string()];
            let scene = "box <1>".into();
            let differences = vec![Difference { scene, names, relative_rmse, noise: 0.01, beyond_noise }];
            summary(&Results { differences, ..results(0.01, -1.0) }, "box <1>").join(" ")
        };
        assert!(!warned(Some(false), Some(0.5)).contains("Warning"));
        let sure = warned(Some(true), Some(0.5));
        assert!(sure.contains("Warning: `reference` and `reference of x` differ by 50 %"), "{sure}");
        assert!(warned(None, Some(0.5)).contains("single image"));
        assert!(warned(None, None).contains("different sizes"));
        assert_eq!([percent(0.123), percent(0.0123), percent(0.00123)], ["12 %", "1.2 %", "0.12 %"]);
    }
}
