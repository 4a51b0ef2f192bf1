//! What a render's report says of everything that altered its estimate.

use dapple_integrator::ledger::Entry;
use dapple_integrator::{Settings, Stats};
use glam::Vec3;
use serde::Serialize;

/// Events, and mean energy of the channels that they removed; see [`dapple_integrator::ledger::Entry`] for its meaning.
#[derive(Serialize)]
pub struct Line {
    count: u64,
    energy: Option<f64>,
}

impl From<Entry> for Line {
    fn from(Entry { count, energy }: Entry) -> Self {
        Self { count, energy: energy.is_finite().then_some(energy) }
    }
}

/// All that could have been done to the estimate; nothing was done in a clean render.
#[derive(Serialize)]
pub struct Ledger {
    clean: bool,
    /// Radiance removed from samples by `--clamp`, summed over samples.
    clamped: Line,
    /// Samples that were not finite and count as black; what they were worth is not known.
    not_finite: Line,
    /// Paths cut at `--max-bounces`: throughput, what would have arrived being unknown.
    depth_cut: Line,
    /// Paths ended because they carried less than 1e-30: throughput.
    faint: Line,
    /// Without roulette paths end at `--max-bounces` alone.
    roulette_off: bool,
    /// `--ambient` stands in for interreflection.
    ambient: bool,
    /// Lights that shine but are neither aimed at nor met by rays.
    lights_culled: u64,
}

impl Ledger {
    /// Of a finished render.
    pub fn new(settings: &Settings, stats: &Stats) -> Self {
        let ambient = settings.ambient != Vec3::ZERO;
        Self {
            clean: stats.ledger.is_clean() && stats.bad_sample_count == 0 && !ambient,
            clamped: stats.ledger.clamped.into(),
            not_finite: Line { count: stats.bad_sample_count, energy: None },
            depth_cut: stats.ledger.depth.into(),
            faint: stats.ledger.faint.into(),
            roulette_off: !settings.roulette,
            ambient,
            lights_culled: stats.ledger.lights_culled,
        }
    }

    /// A line for people about what a clamp took away.
    pub fn summary(&self) -> Option<String> {
        let Line { count, energy } = &self.clamped;
        let took = energy.map_or(String::new(), |e| format!(", which took away radiance {e:.3e} in sum"));
        (*count > 0).then(|| format!("clamped: {count} samples{took}"))
    }
}
