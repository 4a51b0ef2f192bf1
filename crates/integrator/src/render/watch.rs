//! Pass scheduling, time limit, progress reports and cancellation.
//!
//! A separate thread checks the clock and calls the caller, so that a request to stop takes effect within
//! [`POLL_INTERVAL`], however long a tile, a pixel or a sample takes.

use super::outcome::Progress;
use crate::settings::Settings;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Interval between two checks of the clock.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Target duration of a pass, in seconds, which bounds the work lost by a request to stop, beside the sample in
/// progress.
const PASS: f64 = 1.0;

/// Maximum number of samples per pixel of a pass.
const MOST: f64 = 1e6;

/// Determines the length of each pass and when to stop, and reports progress.
pub(super) struct Watch<'a> {
    start: Instant,
    /// Time spent on the render before it was resumed.
    before: Duration,
    settings: &'a Settings,
    progress: &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync),
    pixels: u64,
    /// Samples that all pixels have.
    spp: AtomicU32,
    samples: AtomicU64,
    rays: AtomicU64,
    reported_ms: AtomicU64,
    /// The caller has requested to stop.
    cancelled: AtomicBool,
    /// Samples in progress must end, because the caller has requested to stop, or time is up.
    pub stop: Arc<AtomicBool>,
}

impl<'a> Watch<'a> {
    /// Creates the watch of a render that has taken `before` already, and whose next sample is `next`.
    pub fn new(
        settings: &'a Settings,
        before: Duration,
        next: u32,
        progress: &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Self {
        let spp = next - settings.sample_range().start;
        let pixels = settings.rect().area() as u64;
        Self {
            start: Instant::now(),
            before,
            settings,
            progress,
            pixels,
            spp: AtomicU32::new(spp),
            samples: AtomicU64::new(pixels * u64::from(spp)),
            rays: AtomicU64::new(0),
            reported_ms: AtomicU64::new(0),
            cancelled: AtomicBool::new(false),
            stop: Arc::default(),
        }
    }

    /// Total time spent on the render.
    pub fn elapsed(&self) -> Duration {
        self.before + self.start.elapsed()
    }

    /// End of the pass that begins at sample `next` of every pixel; `None` if the render is over.
    pub fn next_pass(&self, next: u32) -> Option<u32> {
        let range = self.settings.sample_range();
        let spp = next - range.start;
        self.spp.store(spp, Ordering::Relaxed);
        if spp > 0 {
            self.report();
        }
        if next >= range.end || self.is_stopped() {
            return None;
        }
        let round = self.settings.round();
        let seconds = self.elapsed().as_secs_f64() / f64::from(spp.max(1));
        let left = self.left().map_or(f64::INFINITY, |left| left.as_secs_f64());
        if spp > 0 && left < seconds * f64::from(round) {
            // An interrupted round would be discarded.
            return None;
        }
        // A pass takes at most half of the samples that the remaining time is likely to allow, because an interrupted
        // pass is discarded.
        let by_time = if seconds > 0.0 {
            (PASS.min(0.5 * left) / seconds).clamp(1.0, MOST) as u32
        } else {
            MOST as u32
        };
        let size = if spp == 0 { 1 } else { by_time.min(spp.saturating_mul(4)) };
        Some(pass_end(next, size, round).min(range.end))
    }

    /// Runs `work` while a separate thread checks the clock and calls the caller.
    pub fn during<R>(&self, work: impl FnOnce() -> R) -> R {
        let wait = || self.left().unwrap_or(POLL_INTERVAL).clamp(Duration::from_millis(1), POLL_INTERVAL);
        beside(wait, || self.report(), work)
    }

    /// Remaining time, if it is limited.
    fn left(&self) -> Option<Duration> {
        self.settings.limits.time.map(|limit| limit.saturating_sub(self.elapsed()))
    }

    /// Whether no further work must be started.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Whether the caller has requested to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    pub fn tile_done(&self, added: u64, rays: u64) {
        self.samples.fetch_add(added, Ordering::Relaxed);
        self.rays.fetch_add(rays, Ordering::Relaxed);
        let now = self.start.elapsed().as_millis() as u64;
        let reported = self.reported_ms.load(Ordering::Relaxed);
        let due = now >= reported + 100;
        if due
            && self.reported_ms.compare_exchange(reported, now, Ordering::Relaxed, Ordering::Relaxed).is_ok()
        {
            self.report();
        }
    }

    /// Reports progress, and checks whether the render must stop.
    fn report(&self) {
        let elapsed = self.elapsed();
        let (samples, rays) = (self.samples.load(Ordering::Relaxed), self.rays.load(Ordering::Relaxed));
        let by_samples = self
            .settings
            .samples()
            .map(|end| end - self.settings.sample_range().start)
            .map_or(0.0, |spp| samples as f64 / (self.pixels.max(1) as f64 * f64::from(spp)));
        let by_time = self
            .settings
            .limits
            .time
            .filter(|limit| !limit.is_zero())
            .map_or(0.0, |limit| elapsed.as_secs_f64() / limit.as_secs_f64());
        let fraction = by_samples.max(by_time).min(1.0);
        let spp = self.spp.load(Ordering::Relaxed);
        if (self.progress)(Progress { fraction, spp, rays, elapsed }).is_break() {
            self.cancelled.store(true, Ordering::Relaxed);
            self.stop.store(true, Ordering::Relaxed);
        }
        if self.left().is_some_and(|left| left.is_zero()) {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}

/// End of a pass of about `size` samples from `next` on: a power of two of rounds, of which its end is a multiple, so
/// that the sums of a pixel are few nodes of the tree in [`dapple_camera::sums`].
fn pass_end(next: u32, size: u32, round: u32) -> u32 {
    let rounds = 1 << size.div_ceil(round).max(1).ilog2();
    let end = (next / round / rounds).saturating_add(1).saturating_mul(rounds);
    end.saturating_mul(round)
}

/// Runs `work`, and meanwhile, on a separate thread, calls `look` repeatedly after `wait`.
pub(super) fn beside<R>(
    wait: impl Fn() -> Duration + Send,
    look: impl Fn() + Send,
    work: impl FnOnce() -> R,
) -> R {
    thread::scope(|scope| {
        let (working, done) = channel::<()>();
        let watch = move || {
            while done.recv_timeout(wait()) == Err(RecvTimeoutError::Timeout) {
                look();
            }
        };
        // Without a thread, the clock is only checked between tiles.
        let _ = thread::Builder::new().name("watch".into()).spawn_scoped(scope, watch);
        let result = work();
        drop(working);
        result
    })
}

/// Runs `work` with a flag that is set once `stop` returns true.
pub(super) fn until<R>(stop: &(dyn Fn() -> bool + Sync), work: impl FnOnce(&Arc<AtomicBool>) -> R) -> R {
    let stopped = Arc::new(AtomicBool::new(stop()));
    let look = || {
        if stop() {
            stopped.store(true, Ordering::Relaxed);
        }
    };
    beside(|| POLL_INTERVAL, look, || work(&stopped))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_end_at_multiples_of_their_size() {
        for round in [1, 5, 16] {
            let (mut next, mut ends) = (0, Vec::new());
            for size in [1, 4, 16, 50, 7, 7, 100, 100] {
                next = pass_end(next, size * round, round);
                ends.push(next / round);
            }
            assert_eq!(ends, [1, 4, 16, 32, 36, 40, 64, 128]);
        }
        assert_eq!((pass_end(7, 1, 1), pass_end(7, 1, 16), pass_end(16, 17, 16)), (8, 16, 32));
        assert_eq!(pass_end(u32::MAX - 5, 1 << 20, 1), u32::MAX);
    }
}
