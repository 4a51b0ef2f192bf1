//! The progress bar: on standard error, and only where a person may be looking.

use crate::report;
use dapple_integrator::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Steps of the bar.
const STEPS: u64 = 10_000;

/// A bar, or nothing.
pub struct Bar {
    bar: Option<ProgressBar>,
    /// The bits of what is known of the error; NaN = nothing.
    error: AtomicU64,
}

impl Bar {
    /// Hidden when asked to be quiet, and when standard error is not a terminal.
    pub fn new(quiet: bool) -> Self {
        let error = AtomicU64::new(f64::NAN.to_bits());
        if quiet || !std::io::stderr().is_terminal() {
            return Self { bar: None, error };
        }
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{percent:>3}% {bar:24} {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self { bar: Some(bar), error }
    }

    /// Shows how far things are.
    pub fn show(&self, progress: &Progress) {
        if let Some(bar) = &self.bar {
            bar.set_position((progress.fraction.clamp(0.0, 1.0) * STEPS as f64) as u64);
            bar.set_message(message(progress, f64::from_bits(self.error.load(Ordering::Relaxed))));
        }
    }

    /// Shows how far a longer task is, `seconds` after its start.
    pub fn show_task(&self, fraction: f64, seconds: f64, what: &str) {
        if let Some(bar) = &self.bar {
            let fraction = fraction.clamp(0.0, 1.0);
            bar.set_position((fraction * STEPS as f64) as u64);
            let left = seconds * (1.0 - fraction) / fraction;
            bar.set_message(format!(
                "{what} · {} left",
                if left.is_finite() { clock(left) } else { "?".into() }
            ));
        }
    }

    /// A line to standard error, above the bar.
    pub fn say(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| report::say(line)),
            None => report::say(line),
        }
    }

    /// The error to be shown from now on, if it is known.
    pub fn set_error(&self, error: Option<f64>) {
        self.error.store(error.unwrap_or(f64::NAN).to_bits(), Ordering::Relaxed);
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn message(progress: &Progress, error: f64) -> String {
    let seconds = progress.elapsed.as_secs_f64();
    let mrays = progress.rays as f64 / 1e6 / seconds.max(1e-9);
    let left = seconds * (1.0 - progress.fraction) / progress.fraction;
    let error = if error.is_nan() { String::new() } else { format!(" · error {:.2} %", 100.0 * error) };
    format!(
        "{} spp{error} · {mrays:.2} Mrays/s · {} elapsed · {} left",
        progress.spp,
        clock(seconds),
        if left.is_finite() { clock(left) } else { "?".into() },
    )
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

    #[test]
    fn messages_say_rate_and_time_left() {
        let elapsed = Duration::from_secs(90);
        let said = message(&Progress { fraction: 0.25, spp: 16, rays: 90_000_000, elapsed }, f64::NAN);
        assert_eq!(said, "16 spp · 1.00 Mrays/s · 1:30 elapsed · 4:30 left");
        let said = message(&Progress { fraction: 0.0, spp: 0, rays: 0, elapsed: Duration::ZERO }, 0.0123);
        assert_eq!(said, "0 spp · error 1.23 % · 0.00 Mrays/s · 0:00 elapsed · ? left");
        assert_eq!(clock(3725.0), "1:02:05");
    }
}
