//! The image so far of a long render: `NAME.partial.EXT` beside each output, which is removed when the render ends.
//!
//! Without an option it is written after a minute, then at doubling intervals of up to five minutes, and only as often
//! as writing takes no more than one percent of the time. It changes no bit of the final image.

use crate::inputs::Inputs;
use crate::output::{Outputs, refuse_link};
use crate::say::say;
use dapple_integrator::{Advance, Outcome, Renderer};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Time of the first image, and the longest interval between two.
const FIRST: Duration = Duration::from_secs(60);
const LONGEST: Duration = Duration::from_secs(300);

/// Largest part of the time that writing may take.
const SHARE: f64 = 0.01;

/// Expected time for writing one pixel to one file, in seconds, before the first image was written.
const PIXEL: f64 = 1e-6;

/// When partial images are written.
struct Schedule {
    /// The requested interval; none for the default.
    every: Option<Duration>,
    /// Time of the next image; none if there is none.
    next: Option<Duration>,
    interval: Duration,
    /// Total time spent on writing, and time of the last or the first image.
    spent: Duration,
    cost: Duration,
}

impl Schedule {
    /// A schedule with the requested interval, of which zero means never; an image is expected to take `cost`.
    fn new(every: Option<Duration>, cost: Duration) -> Self {
        let interval = every.unwrap_or(FIRST);
        let next = (!interval.is_zero()).then_some(interval);
        Self { every, next, interval, spent: Duration::ZERO, cost }
    }

    /// Whether an image is due.
    fn is_due(&self, elapsed: Duration) -> bool {
        let is_cheap = || (self.spent + self.cost).as_secs_f64() <= SHARE * elapsed.as_secs_f64();
        self.next.is_some_and(|next| elapsed >= next) && (self.every.is_some() || is_cheap())
    }

    /// Notes that an image took `cost` and was complete at `elapsed`.
    fn wrote(&mut self, elapsed: Duration, cost: Duration) {
        (self.spent, self.cost) = (self.spent + cost, cost);
        if self.every.is_none() {
            self.interval = (2 * self.interval).min(LONGEST);
        }
        self.next = self.next.map(|_| elapsed + self.interval);
    }
}

/// Writes partial images of one render.
pub struct Partial<'a> {
    outputs: Outputs,
    /// Adds the metadata to an outcome.
    complete: &'a dyn Fn(Outcome) -> Outcome,
    start: Instant,
    schedule: Schedule,
    written: Vec<PathBuf>,
    is_quiet: bool,
}

impl<'a> Partial<'a> {
    /// Creates the writer for a render with these outputs, of which no partial image may replace an input.
    pub fn new(
        outputs: &Outputs,
        every: Option<Duration>,
        pixels: usize,
        complete: &'a dyn Fn(Outcome) -> Outcome,
        is_quiet: bool,
    ) -> Self {
        let outputs = outputs.partial();
        let cost = Duration::from_secs_f64(PIXEL * pixels as f64 * outputs.paths().count() as f64);
        let schedule = Schedule::new(every, cost);
        Self { outputs, complete, start: Instant::now(), schedule, written: Vec::new(), is_quiet }
    }

    /// Leaves out partial images that would replace an input or the target of a link.
    pub fn spare(&mut self, inputs: &Inputs) {
        self.outputs.keep(|path| inputs.spare([path]).is_ok() && refuse_link(path).is_ok());
    }

    /// Writes the image so far if it is due or requested.
    pub fn between(&mut self, renderer: &Renderer<'_>, is_asked: bool) {
        if is_asked || self.schedule.is_due(self.start.elapsed()) {
            let start = Instant::now();
            self.write(renderer, is_asked);
            self.schedule.wrote(self.start.elapsed(), start.elapsed());
        }
    }

    fn write(&mut self, renderer: &Renderer<'_>, is_asked: bool) {
        let outcome = (self.complete)(renderer.outcome(Advance::Reached));
        let comment = format!("unfinished: {} samples per pixel so far", outcome.stats.spp);
        let (written, failed) = self.outputs.try_write(&outcome, &outcome.film.mean(), Some(&comment));
        for failure in failed {
            say(&format!("warning: the image so far cannot be saved: {failure}; the render continues"));
        }
        if is_asked && !self.is_quiet {
            written.iter().for_each(|path| say(&format!("saved {} with {comment}", path.display())));
        }
        written.into_iter().for_each(|path| {
            if !self.written.contains(&path) {
                self.written.push(path);
            }
        });
    }

    /// Removes the partial images, because the final ones are written.
    pub fn remove(self) {
        for path in self.written {
            if let Err(error) = std::fs::remove_file(&path) {
                tracing::debug!(%error, "cannot remove {}", path.display());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    /// The times of all images of a render of an hour, each of which takes `cost`.
    fn times(every: Option<Duration>, cost: Duration) -> Vec<u64> {
        let mut schedule = Schedule::new(every, cost);
        let due = |second: &u64| {
            let now = Duration::from_secs(*second);
            let is_due = schedule.is_due(now);
            if is_due {
                schedule.wrote(now, cost);
            }
            is_due
        };
        (0..=3600).filter(due).collect()
    }

    #[test]
    fn a_minute_then_doubling_intervals() {
        let quick = Duration::from_millis(10);
        assert_eq!(times(None, quick)[..6], [60, 180, 420, 720, 1020, 1320]);
        assert_eq!(times(Some(10 * SECOND), quick)[..3], [10, 20, 30]);
        assert!(times(Some(Duration::ZERO), quick).is_empty());
    }

    #[test]
    fn at_most_a_percent_of_the_time() {
        for seconds in [1, 3, 10] {
            let cost = seconds * SECOND;
            for (i, at) in (1u64..).zip(times(None, cost)) {
                assert!(100 * i * u64::from(seconds) <= at, "image {i} at {at} s");
            }
        }
        assert_eq!(times(None, 3 * SECOND)[0], 300);
    }
}
