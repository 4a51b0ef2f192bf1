//! Allocation of the time limit of a convergence study.

use std::time::{Duration, Instant};

/// The time limit of a whole command and its elapsed wall time.
#[derive(Clone, Debug)]
pub struct Clock {
    start: Instant,
    budget: Duration,
}

impl Clock {
    /// A clock that was started `already` ago.
    pub fn new(budget: Duration, already: Duration) -> Self {
        let now = Instant::now();
        Self { start: now.checked_sub(already).unwrap_or(now), budget }
    }

    /// Wall time since the start in seconds.
    pub fn elapsed(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Fraction of the time limit that has elapsed, 0 to 1.
    pub fn fraction(&self) -> f64 {
        (self.elapsed() / self.budget.as_secs_f64()).min(1.0)
    }

    /// Seconds left for rendering. A twentieth of the time limit, at least half a second, is reserved for writing
    /// files.
    pub fn left(&self) -> f64 {
        let budget = self.budget.as_secs_f64();
        budget - f64::max(0.05 * budget, 0.5) - self.elapsed()
    }

    /// Whether a task that takes `seconds` fits into the remaining time.
    pub fn has(&self, seconds: f64) -> bool {
        self.left() >= seconds
    }
}

/// Seconds for the first seed of a run: the time left, minus the further seeds of the `sized` runs (given by the time
/// of one seed of each), divided by the `seeds` of the `unsized_runs`. A sixth is kept in reserve, because the speed of
/// a machine varies.
pub fn allowance(left: f64, sized: &[f64], unsized_runs: usize, seeds: usize) -> f64 {
    let promised = sized.iter().sum::<f64>() * seeds.saturating_sub(1) as f64;
    (left - promised).max(0.0) / (1.2 * (unsized_runs.max(1) * seeds.max(1)) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_shared() {
        assert_eq!(allowance(36.0, &[], 3, 5), 2.0);
        // The first run took 1 s of its 2 s: 35 s are left, 4 s of them are reserved.
        assert_eq!(allowance(35.0, &[1.0], 2, 5), 31.0 / 12.0);
        assert_eq!(allowance(-1.0, &[1.0], 2, 5), 0.0);
        let clock = Clock::new(Duration::from_secs(60), Duration::from_secs(30));
        assert!((clock.left() - 27.0).abs() < 0.5 && clock.has(20.0) && !clock.has(28.0));
        assert!((clock.fraction() - 0.5).abs() < 0.01);
    }
}
