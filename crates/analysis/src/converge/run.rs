//! Runs: the methods of a convergence study with their settings.

use dapple_integrator::camera::Camera;
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::{Effect, MethodKind, Settings};

/// A method whose error is measured.
#[derive(Clone, Debug)]
pub struct Run {
    /// Name of the run.
    pub name: String,
    /// The camera, including its lens.
    pub camera: Camera,
    /// All settings except seed and sample count.
    pub settings: Settings,
    /// The effect whose sample count grows with the distribution tracer. The path tracer samples all effects with each
    /// path.
    pub vary: Effect,
}

impl Run {
    /// Whether the first n points do not depend on the total number, so that one render yields all sample counts.
    pub fn is_sequence(&self) -> bool {
        let sequence = matches!(self.settings.pattern, Pattern::Sobol | Pattern::Random);
        self.settings.kind() == MethodKind::Path && sequence
    }

    /// Ratio of successive sample counts. Two-dimensional grids remain square.
    pub fn growth(&self) -> u32 {
        if self.settings.kind() == MethodKind::Distribution { 4 } else { 2 }
    }

    /// Name of the sample count that grows: `spp`, or an effect.
    pub fn varied(&self) -> String {
        match self.settings.kind() {
            MethodKind::Path => "spp".into(),
            MethodKind::Distribution => self.vary.to_string(),
        }
    }

    /// The sampling pattern of the path, or of the effect that varies.
    pub fn pattern(&self) -> Pattern {
        match self.settings.kind() {
            MethodKind::Path => self.settings.pattern,
            MethodKind::Distribution => self.settings.plans.of(self.vary).pattern,
        }
    }

    /// The settings for `count` samples of the independent render `seed`.
    pub fn settings(&self, count: u32, seed: u64) -> Settings {
        let mut settings = Settings { seed, ..self.settings.clone() }.with_time_limit(None).with_spp(count);
        if settings.kind() == MethodKind::Distribution {
            let pattern = self.pattern();
            *settings.plans.of_mut(self.vary) = SampleSet::new(count, pattern);
        }
        settings
    }
}
