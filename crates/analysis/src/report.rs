//! The report of a comparison of methods: a self-contained HTML page.
//!
//! The page contains its plots as SVG and its images as PNG in data URIs, so that it opens from disk without a network.

mod equal;
mod table;
mod words;

pub use words::summary;

use crate::curve::{Error, Over, band};
use crate::plot::{Chart, Series};
use crate::results::{Results, RunRecord};
use crate::statistics::Interval;
use base64::Engine;
use maud::{DOCTYPE, Markup, PreEscaped, html as markup};
use words::file_name;

/// An image of the page.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Label of its button.
    pub label: String,
    /// The image, an encoded PNG.
    pub picture: Vec<u8>,
    /// The error map in false colours, an encoded PNG; `None` for the reference.
    pub errors: Option<Vec<u8>>,
}

/// The relative RMSE of the runs of a scene against `over`, with a guide line at the rate of independent samples.
pub fn chart(results: &Results, scene: &str, over: Over) -> Chart {
    let runs: Vec<&RunRecord> = results.of_scene(scene).collect();
    let line = |run: &&RunRecord| Series {
        name: run.name.clone(),
        points: band(&run.curves(), over, Error::RelativeRmse),
        guide: false,
    };
    let mut series: Vec<Series> = runs.iter().map(line).collect();
    series.extend(guide(&series, over));
    let (x_label, unit) = match over {
        Over::Samples => ("samples per pixel, or points of the varied effect", "samples"),
        Over::Seconds => ("seconds of rendering (wall time)", "seconds"),
        Over::CpuSeconds => ("processor seconds of rendering, all threads together", "processor seconds"),
    };
    Chart {
        title: format!("{}: error against {unit}", file_name(scene)),
        x_label: x_label.into(),
        y_label: "relative RMSE, with 95 % confidence bands over seeds".into(),
        series,
    }
}

/// A guide through the first point of the first line that falls as the inverse root of the cost.
fn guide(series: &[Series], over: Over) -> Option<Series> {
    let shown = |p: &&(f64, Interval)| p.0 > 0.0;
    let (x, start) = series.iter().find_map(|s| s.points.iter().find(shown).copied())?;
    let end = series.iter().flat_map(|s| &s.points).map(|p| p.0).fold(x, f64::max);
    let at = |x_end: f64| {
        let value = start.value * (x / x_end).sqrt();
        (x_end, Interval { value, low: value, high: value })
    };
    let name = match over {
        Over::Samples => "samples^-1/2",
        Over::Seconds => "seconds^-1/2",
        Over::CpuSeconds => "CPU s^-1/2",
    };
    (end > x).then(|| Series { name: name.into(), points: vec![at(x), at(end)], guide: true })
}

/// The page as HTML. `pictures` are by scene, in the order of [`Results::scenes`].
pub fn html(results: &Results, pictures: &[Vec<Shown>]) -> String {
    let scenes = results.scenes();
    let names: Vec<&str> = scenes.iter().map(|scene| file_name(scene)).collect();
    let title = format!("Error against run time: {}", names.join(", "));
    let page = markup! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("report/page.css"))) }
            }
            body {
                h1 { (title) }
                @for (i, scene) in scenes.iter().enumerate() {
                    (section(results, scene, i, pictures.get(i).map_or(&[], Vec::as_slice)))
                }
                (about(results))
                script { (PreEscaped(include_str!("report/flip.js"))) }
            }
        }
    };
    page.into_string()
}

fn section(results: &Results, scene: &str, index: usize, pictures: &[Shown]) -> Markup {
    markup! {
        section {
            h2 { (file_name(scene)) }
            ul.words { @for line in summary(results, scene) { li { (marked(&line)) } } }
            div.plots {
                @for over in [Over::Seconds, Over::CpuSeconds, Over::Samples] {
                    figure { (chart(results, scene, over).markup()) }
                }
            }
            (table::runs(results, scene))
            (equal::tables(results, scene))
            @if !pictures.is_empty() { (viewer(index, pictures)) }
        }
    }
}

/// Buttons and images; the script shows one image at a time.
fn viewer(index: usize, pictures: &[Shown]) -> Markup {
    markup! {
        h3 { "Images" }
        div.viewer id={ "viewer-" (index) } tabindex="0" {
            div.bar {
                @for (i, shown) in pictures.iter().enumerate() {
                    button type="button" data-show=(i) { (shown.label) }
                }
                label { input type="checkbox"; " error map" }
            }
            div.stage {
                @for (i, shown) in pictures.iter().enumerate() {
                    (embedded(i, &shown.label, "picture", &shown.picture))
                    @if let Some(png) = &shown.errors { (embedded(i, &shown.label, "errors", png)) }
                }
            }
            p.note {
                "Select an image with the buttons or the arrow keys. Each run is shown at its last sample count, first \
                 seed. Error map: root of each pixel's squared error over R² + 0.01, R its reference, from 0.001 (black) \
                 to 1 (yellow), logarithmic."
            }
        }
    }
}

/// A PNG as a data URI; only the first image is shown before the script runs.
fn embedded(index: usize, label: &str, kind: &str, png: &[u8]) -> Markup {
    let data = base64::engine::general_purpose::STANDARD.encode(png);
    markup! {
        img data-index=(index) data-kind=(kind) alt={ (label) " (" (kind) ")" } src={ "data:image/png;base64," (data) }
            hidden[index > 0 || kind != "picture"];
    }
}

/// The section on machine, command, references, missing runs, and the meaning of the numbers.
fn about(results: &Results) -> Markup {
    let m = &results.machine;
    let short = |line: &str| {
        results.scenes().iter().fold(line.to_string(), |l, scene| l.replace(scene, file_name(scene)))
    };
    markup! {
        section {
            h2 { "Measurement" }
            dl {
                dt { "Command" } dd { code { (results.command) } }
                dt { "Machine" }
                dd {
                    (m.cpu) ", " (m.threads) " threads"
                    @if m.memory_bytes > 0 { (format!(", {:.1} GB of memory", m.memory_bytes as f64 / 1e9)) }
                    "; " (m.system)
                }
                dt { "Program" } dd { "dapple " (results.version) }
                dt { "Time" }
                dd { (format!("{:.1} s in all, {:.0} s limit of the last call", results.spent_seconds, results.budget_seconds)) }
            }
            h3 { "References" }
            ul { @for r in &results.references { li { (table::reference(r)) } } }
            h3 { "Missing seeds" }
            @if results.left_out.is_empty() { p { "None: every seed of every run was rendered." } }
            @else { ul { @for line in &results.left_out { li { (short(line)) } } } }
            (PreEscaped(include_str!("report/method.html")))
        }
    }
}

/// Text with `code` in backticks and superscript exponents such as N^-1.5.
fn marked(text: &str) -> Markup {
    markup! {
        @for (i, part) in text.split('`').enumerate() {
            @if i % 2 == 1 { code { (part) } } @else { (raised(part)) }
        }
    }
}

fn raised(text: &str) -> Markup {
    let mut parts = text.split("N^");
    let first = parts.next().unwrap_or_default();
    markup! {
        (first)
        @for part in parts {
            @let end = part.find(|c: char| c != '-' && c != '.' && !c.is_ascii_digit()).unwrap_or(part.len());
            "N" sup { (part[..end].replace('-', "−")) } (&part[end..])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Point;
    use crate::results::Seed;

    pub(super) fn results(second: f64, slope: f64) -> Results {
        let run = |name: &str, second: f64, slope: f64| {
            let point = |k: i32, seed: u64| {
                let samples = f64::from(1 << k);
                let wobble = 1.0 + 0.02 * ((seed * 7 + k as u64 * 3) % 5) as f64;
                let mse = samples.powf(slope) * wobble;
                let seconds = samples * second;
                Point { samples, seconds, cpu_seconds: seconds, mse, relmse: mse, relative_rmse: mse.sqrt() }
            };
            let seeds = (1..6).map(|seed| Seed { seed, points: (0..9).map(|k| point(k, seed)).collect() });
            RunRecord {
                scene: "box <1>".into(),
                name: name.into(),
                seeds: seeds.collect(),
                ..RunRecord::default()
            }
        };
        let mut results = Results {
            runs: vec![run("random", 0.01, -1.0), run("other", second, slope)],
            ..Results::default()
        };
        results.sum_up();
        results
    }

    #[test]
    fn the_page_needs_nothing_else() {
        let shown = Shown { label: "a \"b\"".into(), picture: vec![1, 2, 3], errors: Some(vec![4]) };
        let page = html(&results(0.01, -1.5), &[vec![shown]]);
        assert!(page.contains("data:image/png;base64,AQID") && page.contains("box &lt;1&gt;"));
        assert_eq!(page.matches("<svg").count(), 3);
        for outside in ["src=\"http", "href=", "url(", "@import", "fetch("] {
            assert!(!page.contains(outside), "{outside}");
        }
        assert!(page.contains("None: every seed"));
    }

    #[test]
    fn plots_have_a_line_per_run_and_a_guide() {
        let chart = chart(&results(0.01, -1.5), "box <1>", Over::Samples);
        assert_eq!(chart.series.len(), 3);
        assert!(chart.series[2].guide && chart.series[2].points.len() == 2);
    }

    /// An interval that is unknown, because of a single seed or too wide a spread, is reported as not known, and its
    /// ends are not printed.
    #[test]
    fn unknown_intervals_are_not_printed() {
        let mut results = results(0.01, -1.0);
        for (i, seed) in results.runs[1].seeds.iter_mut().enumerate() {
            let factor = [1.0, 30.0, 0.02, 9.0, 0.1][i];
            seed.points.iter_mut().for_each(|p| p.seconds *= factor);
        }
        results.sum_up();
        let s = &results.runs[1].summary;
        assert!(s.speed_up.is_some() && s.speed_up_ci.is_none() && s.efficiency_ci.is_none());
        let page = html(&results, &[]);
        assert!(page.contains("not known"), "{page}");
        let said = summary(&results, "box <1>").join(" ");
        assert!(said.contains("not known") && !said.contains("Fastest"), "{said}");
        results.runs[1].seeds.truncate(1);
        results.sum_up();
        assert!(summary(&results, "box <1>").join(" ").contains("not known"));
        assert!(!html(&results, &[]).contains("inf"));
    }
}
