//! Cost prediction of a sheet, and its deadline.

use dapple_integrator::camera::Camera;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Settings, forecast, render};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Maximum seconds of a speed measurement of one tracer, and its maximum share of a limited time.
const LOOK: f64 = 0.5;
const LOOK_SHARE: f64 = 0.05;

/// Samples per pixel of such a measurement of the path tracer: enough to outweigh the start of threads.
const FEW: u32 = 8;

/// The time limit of the sheet.
pub struct Deadline {
    start: Instant,
    limit: Option<Duration>,
}

impl Deadline {
    /// Starts the clock.
    pub fn new(limit: Option<Duration>) -> Self {
        Self { start: Instant::now(), limit }
    }

    /// Whether the time is up.
    pub fn is_over(&self) -> bool {
        self.limit.is_some_and(|limit| self.start.elapsed() >= limit)
    }

    /// Returns the time limit in seconds, if there is one.
    pub fn seconds(&self) -> Option<f64> {
        self.limit.map(|limit| limit.as_secs_f64())
    }

    /// Returns the seconds for a speed measurement of one tracer.
    fn look(&self) -> f64 {
        self.seconds().map_or(LOOK, |limit| LOOK.min(LOOK_SHARE * limit))
    }

    /// Returns the remaining seconds, if time is limited.
    pub fn left(&self) -> Option<f64> {
        self.limit.map(|limit| limit.saturating_sub(self.start.elapsed()).as_secs_f64())
    }
}

/// Returns an upper bound of the number of rays of the image.
pub fn rays(scene: &Scene, camera: &Camera, settings: &Settings) -> f64 {
    forecast(scene, camera, settings).total() * settings.rect().area() as f64
}

/// Measures the seconds per ray (of the upper bound) of a render with `settings`, from as much of it as `look` seconds
/// allow. `None` if that is too little for an estimate.
fn seconds_per_ray(scene: &Scene, camera: &Camera, settings: &Settings, look: f64) -> Option<f64> {
    let seen = std::sync::Mutex::new((0.0, 0.0));
    let start = Instant::now();
    let outcome = render(scene, camera, settings, &|p| {
        if let Ok(mut seen) = seen.lock() {
            *seen = (p.fraction, p.elapsed.as_secs_f64());
        }
        if start.elapsed().as_secs_f64() < look { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    let (fraction, seconds) = match outcome.stats.stopped {
        false => (1.0, outcome.stats.seconds),
        true => seen.into_inner().ok()?,
    };
    (fraction > 0.0).then(|| seconds / fraction / rays(scene, camera, settings))
}

/// Predicts the seconds of the cells, and of a reference by the path tracer; `None` if they cannot be predicted.
pub fn seconds(
    scene: &Scene,
    camera: &Camera,
    cells: &[&Settings],
    reference: Option<&Settings>,
    deadline: &Deadline,
) -> [Option<f64>; 2] {
    let look = deadline.look();
    let all = |settings: &Settings| rays(scene, camera, settings);
    let least = cells.iter().min_by(|a, b| all(a).total_cmp(&all(b)));
    let total = cells.iter().map(|cell| all(cell)).sum::<f64>();
    let cells = least.and_then(|least| seconds_per_ray(scene, camera, least, look)).map(|rate| rate * total);
    let few = |r: &Settings| r.clone().with_spp(r.spp().map(|n| n.min(FEW)));
    let reference = reference.and_then(|r| Some(seconds_per_ray(scene, camera, &few(r), look)? * all(r)));
    [cells, reference]
}

/// Formats a predicted time, such as "about 12 s".
pub fn about(seconds: Option<f64>) -> String {
    match seconds {
        None => "an unknown time".into(),
        Some(s) if s < 1.0 => "about 1 s".into(),
        Some(s) if s < 100.0 => format!("about {s:.0} s"),
        Some(s) if s < 6000.0 => format!("about {:.0} min", s / 60.0),
        Some(s) => format!("about {:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_short_words() {
        let said = [None, Some(0.2), Some(12.3), Some(600.0), Some(9000.0)].map(about);
        assert_eq!(said, ["an unknown time", "about 1 s", "about 12 s", "about 10 min", "about 2.5 h"]);
        let none = Deadline::new(None);
        assert!(!none.is_over() && none.left().is_none());
        assert!(Deadline::new(Some(Duration::ZERO)).is_over());
    }
}
