//! Outcome of a render: the message about an early end, and the exit code.

use crate::known::Known;
use crate::options::RenderOptions;
use dapple_integrator::camera::Film;
use dapple_integrator::{Outcome, Settings};
use std::process::ExitCode;

/// Exit code of a render that was stopped early or did not reach its error limit.
const STOPPED: u8 = 3;

/// Maximum number of row ranges that a message lists.
const RANGES: usize = 4;

/// Outcome of a render.
pub struct Ending {
    /// Message about an early end, if the image has less than what was requested.
    early: Option<String>,
    /// Pixels without any sample.
    pub unsampled: usize,
}

impl Ending {
    /// Determines the outcome of a render with `settings`; `known` is its error estimate.
    pub fn of(options: &RenderOptions, settings: &Settings, outcome: &Outcome, known: &Known) -> Self {
        let stats = &outcome.stats;
        let by = if stats.stopped { "stopped early" } else { "stopped early by --time-limit" };
        let early = match options.error_limit.filter(|limit| known.bound.is_none_or(|bound| bound > *limit)) {
            _ if stats.spp == 0 => Some(format!("{by}: {}", some_pixels(settings, &outcome.film))),
            Some(limit) if stats.timed_out => Some(format!(
                "{by}: the image has {} samples in every pixel, and its error is {}",
                stats.spp,
                above(limit, known)
            )),
            Some(limit) if !stats.stopped => Some(format!(
                "--error-limit is not reached after {} samples in every pixel: the error is {}",
                stats.spp,
                above(limit, known)
            )),
            _ if stats.stopped || (stats.timed_out && settings.samples().is_some()) => {
                let start = settings.sample_range().start;
                let of = settings.samples().map_or(String::new(), |end| format!(" of {}", end - start));
                Some(format!("{by}: the image has {}{of} samples in every pixel", stats.spp))
            }
            _ => None,
        };
        let unsampled =
            if stats.spp == 0 { pixels(&outcome.film).filter(|(_, n)| *n == 0).count() } else { 0 };
        Self { early, unsampled }
    }

    /// Whether the image has less than what was requested.
    pub fn is_early(&self) -> bool {
        self.early.is_some()
    }

    /// Returns the message about an early end.
    pub fn line(&self) -> Option<&str> {
        self.early.as_deref()
    }

    /// Returns the comment for image metadata if some pixels have no samples.
    pub fn comment(&self) -> Option<&str> {
        self.line().filter(|_| self.unsampled > 0)
    }

    /// Returns the exit code of the process.
    pub fn code(&self) -> ExitCode {
        if self.is_early() { ExitCode::from(STOPPED) } else { ExitCode::SUCCESS }
    }
}

fn above(limit: f64, known: &Known) -> String {
    let limit = 100.0 * limit;
    match known.bound {
        Some(bound) => format!("bounded by {:.2} %, above the limit of {limit:.2} %", 100.0 * bound),
        None => format!("not known to be below {limit:.2} % ({})", known.why),
    }
}

/// Describes which pixels have samples if the first round was not finished.
fn some_pixels(settings: &Settings, film: &Film) -> String {
    let rect = film.rect();
    let sampled = |y: u32| (rect.x0..rect.x1).filter(|x| film.count(*x, y) > 0).count();
    let counts: Vec<usize> = (rect.y0..rect.y1).map(sampled).collect();
    let whole = match settings.round() {
        1 => "a sample".into(),
        n => format!("its {n} samples"),
    };
    let some = match counts.iter().sum::<usize>() {
        0 => "no pixel has a sample".into(),
        n => format!("{n} of {} pixels have samples, {}", rect.area(), rows(rect.y0, &counts)),
    };
    format!("not every pixel has {whole}; {some}; the others are black; the EXR layer 'samples' shows which")
}

/// Lists the rows in which a pixel has samples, as ranges.
fn rows(first: u32, counts: &[usize]) -> String {
    let mut ranges: Vec<[u32; 2]> = Vec::new();
    for (y, _) in (first..).zip(counts).filter(|(_, n)| **n > 0) {
        match ranges.last_mut() {
            Some([_, last]) if *last + 1 == y => *last = y,
            _ => ranges.push([y, y]),
        }
    }
    let more = if ranges.len() > RANGES { " and more" } else { "" };
    let named = ranges.iter().take(RANGES).map(|[a, b]| format!("{a} to {b}")).collect::<Vec<_>>();
    format!("in rows {}{more}", named.join(", "))
}

fn pixels(film: &Film) -> impl Iterator<Item = ((u32, u32), u64)> {
    let rect = film.rect();
    let all = (rect.y0..rect.y1).flat_map(move |y| (rect.x0..rect.x1).map(move |x| (x, y)));
    all.map(|(x, y)| ((x, y), film.count(x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_told_as_ranges() {
        assert_eq!(rows(8, &[1, 2, 0, 0, 5]), "in rows 8 to 9, 12 to 12");
        assert_eq!(rows(0, &[1, 0, 1, 0, 1, 0, 1, 0, 1]), "in rows 0 to 0, 2 to 2, 4 to 4, 6 to 6 and more");
    }
}
