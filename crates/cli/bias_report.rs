//! What a render's report says of everything that altered its estimate.

use dapple_integrator::bias_report::Entry;
use dapple_integrator::{Settings, Stats};
use glam::Vec3;
use serde::Serialize;

/// Events, and mean energy of the channels that they removed; see [`dapple_integrator::bias_report::Entry`] for its meaning.
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
pub struct BiasReport {
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
    /// Bodies forgotten where more than 16 lie within each other: throughput of the paths.
    nested: Line,
    /// Shadow rays lost among more than 256 clear surfaces: radiance.
    panes: Line,
    /// `--transparent-shadows` lets shadow rays pass smooth solid matter straight on.
    transparent_shadows: bool,
    /// Point, spot and distant lights whose light a mirror or refraction sends on: that part of it nothing finds.
    lights_unreachable: u64,
    /// Lights that shine but are neither aimed at nor met by rays.
    lights_culled: u64,
}

impl BiasReport {
    /// Of a finished render.
    pub fn new(settings: &Settings, stats: &Stats) -> Self {
        let ambient = settings.ambient != Vec3::ZERO;
        Self {
            clean: stats.bias.is_clean()
                && stats.bad_sample_count == 0
                && !ambient
                && !settings.transparent_shadows,
            clamped: stats.bias.clamped.into(),
            not_finite: Line { count: stats.bad_sample_count, energy: None },
            depth_cut: stats.bias.depth.into(),
            faint: stats.bias.faint.into(),
            roulette_off: !settings.roulette(),
            ambient,
            nested: stats.bias.nested.into(),
            panes: stats.bias.panes.into(),
            transparent_shadows: settings.transparent_shadows,
            lights_unreachable: stats.bias.lights_unreachable,
            lights_culled: stats.bias.lights_culled,
        }
    }

    /// Lines for people about what is not as the light would have it.
    pub fn summary(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Line { count: count @ 1.., energy } = self.clamped {
            let took = energy.map_or(String::new(), |e| format!(", which took away radiance {e:.3e} in sum"));
            lines.push(format!("clamped: {count} samples{took}"));
        }
        if self.transparent_shadows {
            lines.push(
                "transparent shadows: shadow rays pass smooth glass straight on, an approximation".into(),
            );
        }
        if self.lights_unreachable > 0 {
            let count = self.lights_unreachable;
            lines.push(format!(
                "light left out: {count} point, spot or distant lights shine on mirrors or through glass, if at all, where nothing finds what these send on"
            ));
        }
        if let Line { count: count @ 1.., .. } = self.nested {
            lines.push(format!("bodies forgotten: {count} times more than 16 lay within each other"));
        }
        if let Line { count: count @ 1.., .. } = self.panes {
            lines.push(format!("shadow rays lost: {count} met more than 256 clear surfaces"));
        }
        lines
    }
}
