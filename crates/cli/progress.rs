//! Progress of long work: a bar if standard error is a terminal, otherwise a line at intervals, or the messages of a
//! scheduler.
//!
//! The bar is one line that fits the terminal: on narrow terminals the less important parts are omitted, and the bar
//! itself takes the remaining width.

use crate::say::say;
use crate::standard_output;
use console::{Term, measure_text_width};
use dapple_integrator::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt;
use std::io::IsTerminal;
use std::str::FromStr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Minimum and maximum width of the bar itself, in columns; a narrower bar is omitted.
const BAR: (usize, usize) = (6, 24);

/// Parts of a higher rank are omitted before the bar is.
const RANK: u8 = 3;

/// Assumed width of a terminal that does not report its width, in columns.
const COLUMNS: usize = 80;

/// Time of the first line where no bar is drawn, and the longest interval between two.
const FIRST: Duration = Duration::from_secs(10);
const LONGEST: Duration = Duration::from_secs(60);

/// Interval between two messages to a scheduler.
const OFTEN: Duration = Duration::from_secs(1);

/// How progress is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A bar on a terminal, otherwise lines.
    #[default]
    Auto,
    /// A line on standard error after 10 s, at doubling intervals of up to a minute.
    Lines,
    /// `openjd_progress` and `openjd_status` on standard output, as schedulers that run Open Job Description read them.
    OpenJd,
}

impl Style {
    const ALL: [(Self, &'static str); 3] =
        [(Self::Auto, "auto"), (Self::Lines, "lines"), (Self::OpenJd, "openjd")];
}

impl FromStr for Style {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.iter().find(|(_, name)| text.eq_ignore_ascii_case(name));
        found.map(|(style, _)| *style).ok_or_else(|| "expected auto, lines or openjd".into())
    }
}

impl fmt::Display for Style {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = Self::ALL.iter().find(|(style, _)| style == self);
        f.write_str(found.map_or("auto", |(_, name)| name))
    }
}

/// When the next line is due.
struct Interval {
    start: Instant,
    next: Duration,
    step: Duration,
    longest: Duration,
}

impl Interval {
    fn new(first: Duration, longest: Duration) -> Mutex<Self> {
        Mutex::new(Self { start: Instant::now(), next: first, step: first, longest })
    }

    /// Whether a line is due `now` after the start; then the next one is scheduled.
    fn is_due(&mut self, now: Duration) -> bool {
        if now < self.next {
            return false;
        }
        self.step = (2 * self.step).min(self.longest);
        self.next = now + self.step;
        true
    }
}

/// Where progress goes.
enum Shown {
    Bar(ProgressBar),
    Lines(Mutex<Interval>),
    OpenJd(Mutex<Interval>),
    Nowhere,
}

/// A progress bar, lines, or nothing.
pub struct Bar {
    shown: Shown,
    /// Bits of the current error estimate; NaN = unknown.
    error: AtomicU64,
}

impl Bar {
    /// Creates a bar, or lines where standard error is not a terminal; nothing if `quiet` is set.
    pub fn new(quiet: bool) -> Self {
        Self::of(quiet, Style::Auto)
    }

    /// Creates a bar of the given style. The messages to a scheduler are sent even if `quiet` is set.
    pub fn of(quiet: bool, style: Style) -> Self {
        let shown = match style {
            Style::OpenJd => Shown::OpenJd(Interval::new(OFTEN, OFTEN)),
            _ if quiet => Shown::Nowhere,
            Style::Auto if std::io::stderr().is_terminal() => Shown::Bar(bar()),
            _ => Shown::Lines(Interval::new(FIRST, LONGEST)),
        };
        Self { shown, error: AtomicU64::new(f64::NAN.to_bits()) }
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
        let is_due = |interval: &Mutex<Interval>| {
            interval.lock().is_ok_and(|mut interval| {
                let now = interval.start.elapsed();
                interval.is_due(now)
            })
        };
        match &self.shown {
            Shown::Bar(bar) => {
                let columns =
                    Term::stderr().size_checked().map_or(COLUMNS, |(_, columns)| usize::from(columns));
                // The last column stays free: some terminals wrap to the next line when it is written.
                bar.set_message(line(columns.saturating_sub(1), fraction, parts()));
                bar.tick();
            }
            Shown::Lines(interval) if is_due(interval) => {
                say(&format!("{} % · {}", percent(fraction), joined(parts())));
            }
            Shown::OpenJd(interval) if is_due(interval) => tell_scheduler(fraction, &joined(parts())),
            Shown::Lines(_) | Shown::OpenJd(_) | Shown::Nowhere => {}
        }
    }

    /// Prints a line to standard error, above the bar.
    pub fn say(&self, line: &str) {
        self.aside(|| say(line));
    }

    /// Whether the bar is visible.
    pub fn is_shown(&self) -> bool {
        matches!(self.shown, Shown::Bar(_))
    }

    /// Runs a function that writes to the terminal, above the bar.
    pub fn aside(&self, write: impl FnOnce()) {
        match &self.shown {
            Shown::Bar(bar) => bar.suspend(write),
            _ => write(),
        }
    }

    /// Sets the error estimate to show; `None` if it is unknown.
    pub fn set_error(&self, error: Option<f64>) {
        self.error.store(error.unwrap_or(f64::NAN).to_bits(), Ordering::Relaxed);
    }

    /// Removes the bar.
    pub fn finish(&self) {
        match &self.shown {
            Shown::Bar(bar) => bar.finish_and_clear(),
            Shown::OpenJd(_) => tell_scheduler(1.0, "rendered"),
            Shown::Lines(_) | Shown::Nowhere => {}
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

/// Prints the messages of Open Job Description: the percentage done, and a text.
fn tell_scheduler(fraction: f64, status: &str) {
    standard_output::result(&format!("openjd_progress: {:.1}", 100.0 * sound(fraction)));
    standard_output::result(&format!("openjd_status: {status}"));
}

/// A fraction between 0 and 1.
fn sound(fraction: f64) -> f64 {
    if fraction.is_nan() { 0.0 } else { fraction.clamp(0.0, 1.0) }
}

fn percent(fraction: f64) -> u32 {
    (100.0 * sound(fraction)).floor() as u32
}

fn joined(parts: Vec<(u8, String)>) -> String {
    parts.into_iter().map(|(_, part)| part).collect::<Vec<_>>().join(" · ")
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
    let fraction = sound(fraction);
    let percent = format!("{:>3}%", percent(fraction));
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
    let said = joined(parts);
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

    #[test]
    fn lines_come_at_doubling_intervals() {
        let second = Duration::from_secs(1);
        let mut interval = Interval { start: Instant::now(), next: FIRST, step: FIRST, longest: LONGEST };
        let times: Vec<u32> = (0..400).filter(|now| interval.is_due(*now * second)).collect();
        assert_eq!(times, [10, 30, 70, 130, 190, 250, 310, 370]);
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
