//! The report of a comparison of methods: a self-contained HTML page.
//!
//! The page contains its plots as SVG and its images as PNG in data URIs, so that it opens from disk without a network.

mod equal;
mod table;
mod words;

pub use words::summary;

use crate::curve::{Error, Over, band};
use crate::plot::{Chart, Series, escaped};
use crate::results::{Results, RunRecord};
use crate::statistics::Interval;
use base64::Engine;
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
    let none = Vec::new();
    let sections: String = scenes
        .iter()
        .enumerate()
        .map(|(i, scene)| section(results, scene, i, pictures.get(i).unwrap_or(&none)))
        .collect();
    let names: Vec<&str> = scenes.iter().map(|scene| file_name(scene)).collect();
    let title = format!("Error against run time: {}", escaped(&names.join(", ")));
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{sections}{}\n<script>\n{}</script>\n</body>\n</html>\n",
        include_str!("report/page.css"),
        about(results),
        include_str!("report/flip.js"),
    )
}

fn section(results: &Results, scene: &str, index: usize, pictures: &[Shown]) -> String {
    let said = summary(results, scene);
    let said: String = said.iter().map(|line| format!("<li>{}</li>\n", marked(line))).collect();
    let plot = |over| format!("<figure>{}</figure>\n", chart(results, scene, over).svg());
    let plots = [Over::Seconds, Over::CpuSeconds, Over::Samples].map(plot).concat();
    format!(
        "<section>\n<h2>{}</h2>\n<ul class=\"words\">\n{said}</ul>\n<div class=\"plots\">\n{plots}</div>\n{}{}{}</section>\n",
        escaped(file_name(scene)),
        table::runs(results, scene),
        equal::tables(results, scene),
        viewer(index, pictures),
    )
}

/// Buttons and images; the script shows one image at a time.
fn viewer(index: usize, pictures: &[Shown]) -> String {
    if pictures.is_empty() {
        return String::new();
    }
    let button = |(i, shown): (usize, &Shown)| {
        format!("<button type=\"button\" data-show=\"{i}\">{}</button>\n", escaped(&shown.label))
    };
    let image = |(i, shown): (usize, &Shown)| {
        let one = |png: &[u8], kind: &str| {
            let data = base64::engine::general_purpose::STANDARD.encode(png);
            let hidden = if i == 0 && kind == "picture" { "" } else { " hidden" };
            format!(
                "<img data-index=\"{i}\" data-kind=\"{kind}\" alt=\"{} ({kind})\" \
                 src=\"data:image/png;base64,{data}\"{hidden}>\n",
                escaped(&shown.label)
            )
        };
        let errors = shown.errors.as_ref().map(|png| one(png, "errors"));
        one(&shown.picture, "picture") + &errors.unwrap_or_default()
    };
    let buttons: String = pictures.iter().enumerate().map(button).collect();
    let images: String = pictures.iter().enumerate().map(image).collect();
    format!(
        "<h3>Images</h3>\n<div class=\"viewer\" id=\"viewer-{index}\" tabindex=\"0\">\n<div class=\"bar\">{buttons}\
         <label><input type=\"checkbox\"> error map</label></div>\n<div class=\"stage\">{images}</div>\n\
         <p class=\"note\">Select an image with the buttons or the arrow keys. Each run is shown at its last sample \
         count, first seed. Error map: root of each pixel's squared error over R² + 0.01, R its reference, from 0.001 \
         (black) to 1 (yellow), logarithmic.</p>\n</div>\n"
    )
}

/// The section on machine, command, references, missing runs, and the meaning of the numbers.
fn about(results: &Results) -> String {
    let m = &results.machine;
    let memory = match m.memory_bytes {
        0 => String::new(),
        bytes => format!(", {:.1} GB of memory", bytes as f64 / 1e9),
    };
    let references: String =
        results.references.iter().map(|r| format!("<li>{}</li>\n", table::reference(r))).collect();
    let left_out = match results.left_out.is_empty() {
        true => "<p>None: every seed of every run was rendered.</p>".into(),
        false => {
            let short = |line: &String| {
                results.scenes().iter().fold(line.clone(), |l, scene| l.replace(scene, file_name(scene)))
            };
            let items = results.left_out.iter().map(|l| format!("<li>{}</li>", escaped(&short(l))));
            format!("<ul>{}</ul>", items.collect::<String>())
        }
    };
    format!(
        "<section>\n<h2>Measurement</h2>\n<dl>\n<dt>Command</dt><dd><code>{}</code></dd>\n\
         <dt>Machine</dt><dd>{}, {} threads{memory}; {}</dd>\n<dt>Program</dt><dd>dapple {}</dd>\n\
         <dt>Time</dt><dd>{:.1} s in all, limit of the last call {:.0} s</dd>\n</dl>\n\
         <h3>References</h3>\n<ul>\n{references}</ul>\n<h3>Missing seeds</h3>\n{left_out}\n{}\n</section>\n",
        escaped(&results.command),
        escaped(&m.cpu),
        m.threads,
        escaped(&m.system),
        escaped(&results.version),
        results.spent_seconds,
        results.budget_seconds,
        include_str!("report/method.html"),
    )
}

/// Converts text with `code` in backticks and exponents such as N^-1.5 to HTML.
fn marked(text: &str) -> String {
    let escaped = escaped(text);
    let parts = escaped.split('`').enumerate();
    parts.map(|(i, part)| if i % 2 == 1 { format!("<code>{part}</code>") } else { raised(part) }).collect()
}

fn raised(text: &str) -> String {
    let mut parts = text.split("N^");
    let mut out = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let end = part.find(|c: char| c != '-' && c != '.' && !c.is_ascii_digit()).unwrap_or(part.len());
        let exponent = part[..end].replace('-', "−");
        out += &format!("N<sup>{exponent}</sup>{}", &part[end..]);
    }
    out
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
