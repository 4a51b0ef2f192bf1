//! The bias report of a render: counts every deliberate bias of its estimate.

use dapple_integrator::bias_report::Entry;
use dapple_integrator::{Settings, Stats};
use glam::Vec3;
use serde::Serialize;

/// Count of events and mean energy over the channels that they removed; see [`dapple_integrator::bias_report::Entry`].
#[derive(Serialize)]
pub struct Line {
    count: u64,
    energy: Option<f64>,
}

impl From<Entry> for Line {
    fn from(entry: Entry) -> Self {
        Self { count: entry.count, energy: Some(entry.energy).filter(|e| e.is_finite()) }
    }
}

/// All deliberate biases; a clean render has none.
#[derive(Serialize)]
pub struct BiasReport {
    clean: bool,
    /// Radiance removed from samples by `--clamp`, summed over samples.
    clamped: Line,
    /// Samples that were not finite and count as black; their energy is unknown.
    not_finite: Line,
    /// Paths cut at `--max-bounces`; energy is throughput, because the missing radiance is unknown.
    depth_cut: Line,
    /// Paths ended because their throughput fell below 1e-30; energy is throughput.
    faint: Line,
    /// Whether Russian roulette is off; paths then end only at `--max-bounces`.
    roulette_off: bool,
    /// Whether `--ambient` replaces interreflection.
    ambient: bool,
    /// Media dropped where more than 16 solids are nested; energy is the throughput of the paths.
    nested: Line,
    /// Shadow rays dropped after more than 256 transparent surfaces; energy is radiance.
    panes: Line,
    /// Whether `--transparent-shadows` lets shadow rays pass straight through smooth solid media.
    transparent_shadows: bool,
    /// Point, spot and distant lights whose specular caustics no sampling strategy can find.
    lights_unreachable: u64,
    /// Lights that emit but are neither sampled nor hit by rays.
    lights_culled: u64,
}

impl BiasReport {
    /// Creates the report of a finished render.
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

    /// Formats the biases for people.
    pub fn summary(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Line { count: count @ 1.., energy } = self.clamped {
            let took =
                energy.map_or(String::new(), |e| format!(", which removed a total radiance of {e:.3e}"));
            lines.push(format!("clamped: {count} samples{took}"));
        }
        if self.transparent_shadows {
            lines.push(
                "transparent shadows: shadow rays pass straight through smooth glass, an approximation"
                    .into(),
            );
        }
        if self.lights_unreachable > 0 {
            let count = self.lights_unreachable;
            lines.push(format!(
                "missing caustics: light of {count} point, spot or distant lights via mirrors or glass, if any, \
                 cannot be sampled"
            ));
        }
        if let Line { count: count @ 1.., .. } = self.nested {
            lines.push(format!("nested media dropped: {count} times more than 16 solids were nested"));
        }
        if let Line { count: count @ 1.., .. } = self.panes {
            lines.push(format!("shadow rays dropped: {count} crossed more than 256 transparent surfaces"));
        }
        lines
    }
}
