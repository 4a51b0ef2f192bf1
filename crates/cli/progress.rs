//! The progress bar: on standard error, and only if that is a terminal.
//!
//! The bar is one line that fits the terminal: on narrow terminals the less important parts are omitted, and the bar
//! itself takes the remaining width.

use crate::say::say;
use console::{Term, measure_text_width};
use dapple_integrator::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Minimum and maximum width of the bar itself, in columns; a narrower bar is omitted.
const BAR: (usize, usize) = (6, 24);

/// Parts of a higher rank are omitted before the bar is.
const RANK: u8 = 3;

/// Assumed width of a terminal that does not report its width, in columns.
const COLUMNS: usize = 80;

/// A progress bar, or nothing.
pub struct Bar {
    bar: Option<ProgressBar>,
    /// Bits of the current error estimate; NaN = unknown.
    error: AtomicU64,
}

impl Bar {
    /// Creates a bar; hidden if `quiet` is set or standard error is not a terminal.
    pub fn new(quiet: bool) -> Self {
        let error = AtomicU64::new(f64::NAN.to_bits());
        if quiet || !std::io::stderr().is_terminal() {
            return Self { bar: None, error };
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self { bar: Some(bar), error }
    }

    /// Shows the progress of a render.
    pub fn show(&self, progress: &Progress) {
        let error = f64::from_bits(self.error.load(Ordering::Relaxed));
        self.draw(progress.fraction, || parts(progress, error));
    }

    /// Shows the progress of a longer task, `seconds` after its start.
    pub fn show_task(&self, fraction: f64, seconds: f64, what: &str) {
        self.draw(fraction, || vec![(1, what.into()), (2, left(fraction.clamp(0.0, 1.0), seconds))]);
    }

    fn draw(&self, fraction: f64, parts: impl FnOnce() -> Vec<(u8, String)>) {
        if let Some(bar) = &self.bar {
            let columns = Term::stderr().size_checked().map_or(COLUMNS, |(_, columns)| usize::from(columns));
            // The last column stays free: some terminals wrap to the next line when it is written.
            bar.set_message(line(columns.saturating_sub(1), fraction, parts()));
            bar.tick();
        }
    }

    /// Prints a line to standard error, above the bar.
    pub fn say(&self, line: &str) {
        self.aside(|| say(line));
    }

    /// Whether the bar is visible.
    pub fn is_shown(&self) -> bool {
        self.bar.is_some()
    }

    /// Runs a function that writes to the terminal, above the bar.
    pub fn aside(&self, write: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }

    /// Sets the error estimate to show; `None` if it is unknown.
    pub fn set_error(&self, error: Option<f64>) {
        self.error.store(error.unwrap_or(f64::NAN).to_bits(), Ordering::Relaxed);
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Returns the texts beside the bar, in order, each with its rank: rank 1 is omitted last.
fn parts(progress: &Progress, error: f64) -> Vec<(u8, String)> {
    let seconds = progress.elapsed.as_secs_f64();
    let mrays = progress.rays as f64 / 1e6 / seconds.max(1e-9);
    let mut parts = vec![(2, format!("{} spp", progress.spp))];
    if !error.is_nan() {
        parts.push((3, format!("error {:.2} %", 100.0 * error)));
    }
    parts.push((4, format!("{mrays:.2} Mrays/s")));
    parts.push((5, format!("{} elapsed", clock(seconds))));
    parts.push((1, left(progress.fraction, seconds)));
    parts
}

fn left(fraction: f64, seconds: f64) -> String {
    let left = seconds * (1.0 - fraction) / fraction;
    format!("{} left", if left.is_finite() { clock(left) } else { "?".into() })
}

/// Formats one line of at most `columns`: the percentage, a bar, and as many of the parts as fit.
fn line(columns: usize, fraction: f64, mut parts: Vec<(u8, String)>) -> String {
    let fraction = if fraction.is_nan() { 0.0 } else { fraction.clamp(0.0, 1.0) };
    let percent = format!("{:>3.0}%", (100.0 * fraction).floor());
    let free = columns.saturating_sub(percent.len());
    // A space precedes each part, or a dot between two parts.
    let width = |parts: &[(u8, String)]| {
        let words: usize = parts.iter().map(|(_, part)| measure_text_width(part)).sum();
        words + (3 * parts.len()).saturating_sub(2)
    };
    // Parts of a higher rank are less important than the bar.
    let wanted = |parts: &[(u8, String)]| {
        let spare = if parts.iter().any(|(rank, _)| *rank > RANK) { BAR.0 + 1 } else { 0 };
        width(parts) + spare
    };
    while wanted(&parts) > free {
        let Some(last) = (0..parts.len()).max_by_key(|i| parts[*i].0) else { break };
        parts.remove(last);
    }
    let room = (free - width(&parts)).saturating_sub(1).min(BAR.1);
    let bar = if room < BAR.0 { String::new() } else { format!(" {}", blocks(room, fraction)) };
    let said = parts.into_iter().map(|(_, part)| part).collect::<Vec<_>>().join(" · ");
    format!("{percent}{bar} {said}").trim_end().chars().take(columns).collect()
}

fn blocks(width: usize, fraction: f64) -> String {
    let full = (fraction * width as f64) as usize;
    "█".repeat(full) + &"░".repeat(width - full)
}

/// Seconds as `m:ss` or `h:mm:ss`.
fn clock(seconds: f64) -> String {
    let s = Duration::from_secs_f64(seconds.clamp(0.0, 1e9)).as_secs();
    let (h, m, s) = (s / 3600, s / 60 % 60, s % 60);
    if h > 0 { format!("{h}:{m:02}:{s:02}") } else { format!("{m}:{s:02}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(fraction: f64, spp: u32, rays: u64, seconds: u64, error: f64) -> Vec<(u8, String)> {
        parts(&Progress { fraction, spp, rays, elapsed: Duration::from_secs(seconds) }, error)
    }

    #[test]
    fn messages_say_rate_and_time_left() {
        let said = line(200, 0.25, at(0.25, 16, 90_000_000, 90, f64::NAN));
        let bar = "██████░░░░░░░░░░░░░░░░░░";
        assert_eq!(said, format!(" 25% {bar} 16 spp · 1.00 Mrays/s · 1:30 elapsed · 4:30 left"));
        let said = line(200, 0.0, at(0.0, 0, 0, 0, 0.0123));
        assert!(said.ends_with("0 spp · error 1.23 % · 0.00 Mrays/s · 0:00 elapsed · ? left"), "{said}");
        assert_eq!(clock(3725.0), "1:02:05");
    }

    /// The line fits however narrow the terminal and however large the numbers are; the remaining time is omitted last.
    #[test]
    fn the_line_fits_the_terminal() {
        let small = || at(0.5, 8, 1_000_000, 2, f64::NAN);
        let large = || at(0.001, 1 << 20, u64::MAX, 360_000, 123.456);
        for columns in 0..140 {
            for parts in [small(), large(), vec![(1, "scene 1 of 3: reference".into()), (2, left(0.0, 1.0))]]
            {
                let said = line(columns, 0.5, parts);
                assert!(measure_text_width(&said) <= columns, "{columns}: {said}");
            }
        }
        let said = line(60, 0.001, large());
        assert!(said.contains("left") && said.contains("spp") && said.contains("error"), "{said}");
        let said = line(60, 0.5, small());
        assert!(said.contains("left") && said.contains('█') && said.contains("Mrays/s"), "{said}");
        let said = line(40, 0.5, small());
        assert!(said.contains("left") && said.contains('█') && said.contains("spp"), "{said}");
        assert_eq!(line(4, 1.0, small()), "100%");
        assert_eq!(line(3, f64::NAN, small()), "  0");
    }
}
