//! A method with its settings, as a comparison sees it.

use dapple_integrator::camera::Camera;
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::{Effect, MethodKind, Settings};

/// A method whose error is looked at.
#[derive(Clone, Debug)]
pub struct Run {
    /// What it is called.
    pub name: String,
    /// With its lens.
    pub camera: Camera,
    /// All settings but seed and sample count.
    pub settings: Settings,
    /// The integral whose count grows with the distribution tracer; the path tracer's samples are of all at once.
    pub vary: Effect,
}

impl Run {
    /// Whether the first n points are the same however many follow: then one render shows all counts.
    pub fn is_sequence(&self) -> bool {
        let sequence = matches!(self.settings.pattern, Pattern::Sobol | Pattern::Random);
        self.settings.kind() == MethodKind::Path && sequence
    }

    /// From one count to the next: two-dimensional grids stay square.
    pub fn growth(&self) -> u32 {
        if self.settings.kind() == MethodKind::Distribution { 4 } else { 2 }
    }

    /// What grows.
    pub fn varied(&self) -> String {
        match self.settings.kind() {
            MethodKind::Path => "spp".into(),
            MethodKind::Distribution => self.vary.to_string(),
        }
    }

    /// The points' pattern: of the path, or of the integral that varies.
    pub fn pattern(&self) -> Pattern {
        match self.settings.kind() {
            MethodKind::Path => self.settings.pattern,
            MethodKind::Distribution => self.settings.plans.of(self.vary).pattern,
        }
    }

    /// The settings for `count` samples of independent render `seed`.
    pub fn settings(&self, count: u32, seed: u64) -> Settings {
        let mut settings = Settings { seed, ..self.settings.clone() }.with_time_limit(None).with_spp(count);
        if settings.kind() == MethodKind::Distribution {
            let pattern = self.pattern();
            *settings.plans.of_mut(self.vary) = SampleSet::new(count, pattern);
        }
        settings
    }
}
