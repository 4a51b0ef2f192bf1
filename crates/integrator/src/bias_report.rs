//! What was done to the estimate that the light did not do? Every event counted, with the energy it removed.
//!
//! A render with clean settings (roulette, no clamp, more bounces than paths take) has nothing here. Counting costs
//! something only where an event happens.

use dapple_scene::Scene;
use glam::Vec3;

/// Throughput below which a path ends: what it could still bring is lost in the rounding of any picture.
pub(crate) const FAINT: f32 = 1e-30;

/// Why a path ended before the light did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Truncation {
    /// At `max_bounces`.
    Depth,
    /// Its throughput fell below [`FAINT`].
    Faint,
    /// It did not end, but lies within more bodies than it can remember.
    Nested,
    /// A shadow ray met more clear surfaces than it passes.
    Panes,
}

/// Events and what they removed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// How many.
    pub count: u64,
    /// Mean of the channels, summed. For clamped samples: radiance, summed over samples. For paths that were cut: their
    /// throughput, that is the radiance lost if radiance 1 had arrived, for what would have arrived is not known.
    pub energy: f64,
}

impl Entry {
    fn add(&mut self, energy: Vec3) {
        self.count += 1;
        self.energy += f64::from(energy.element_sum()) / 3.0;
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.energy += other.energy;
    }
}

/// What altered the estimate. Non-finite samples are counted in [`crate::Stats`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BiasReport {
    /// Samples brighter than the clamp.
    pub clamped: Entry,
    /// Paths that ended at the largest number of bounces though they could have gone on.
    pub depth: Entry,
    /// Paths that ended because they carried less than 1e-30.
    pub faint: Entry,
    /// Events in which a body was forgotten because too many lie within each other: throughput of the path.
    pub nested: Entry,
    /// Shadow rays lost among too many clear surfaces: radiance that would have come if all of them let it through.
    pub panes: Entry,
    /// Point, spot and distant lights whose light can reach a surface by way of a mirror or of refraction: nothing finds
    /// that part of it. An upper bound: whether it falls on such surfaces is not looked at.
    pub lights_unreachable: u64,
    /// Lights that shine but are neither aimed at nor met by rays: none, unless their power overflows.
    pub lights_culled: u64,
}

/// Lights of `scene` that could contribute and cannot be found.
pub(crate) fn culled(scene: &Scene) -> u64 {
    let aimed = |i: usize| scene.light_choice.as_ref().is_some_and(|choice| choice.contains(i));
    let hidden = scene.lights.iter().enumerate().filter(|&(i, light)| light.is_delta() && !aimed(i));
    hidden.filter(|(_, light)| light.power(1.0) != Vec3::ZERO).count() as u64
}

impl BiasReport {
    /// Whether nothing happened.
    pub fn is_clean(&self) -> bool {
        *self == Self::default()
    }

    /// Energies: clamped, cut at the largest number of bounces, faint.
    pub(crate) fn energies(&self) -> [f64; 3] {
        [self.clamped, self.depth, self.faint].map(|entry| entry.energy)
    }

    pub(crate) fn cut(&mut self, why: Truncation, throughput: Vec3) {
        match why {
            Truncation::Depth => self.depth.add(throughput),
            Truncation::Faint => self.faint.add(throughput),
            Truncation::Nested => self.nested.add(throughput),
            Truncation::Panes => self.panes.add(throughput),
        }
    }

    /// `value` made darker, in its own colour, until no channel exceeds `most`. A value that is not finite stays what it
    /// is, and is told as that.
    pub(crate) fn clamp(&mut self, value: Vec3, most: f32) -> Vec3 {
        let largest = value.max_element();
        if !(largest > most && value.is_finite()) {
            return value;
        }
        let clamped = value * (most / largest);
        self.clamped.add(value - clamped);
        clamped
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.clamped.merge(&other.clamped);
        self.depth.merge(&other.depth);
        self.faint.merge(&other.faint);
        self.nested.merge(&other.nested);
        self.panes.merge(&other.panes);
        self.lights_unreachable += other.lights_unreachable;
        self.lights_culled += other.lights_culled;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clamp_keeps_the_colour_and_what_it_took_is_known() {
        let mut bias = BiasReport::default();
        assert_eq!(bias.clamp(Vec3::new(1.0, 2.0, 0.5), 2.0), Vec3::new(1.0, 2.0, 0.5));
        assert!(bias.is_clean());
        assert_eq!(bias.clamp(Vec3::new(8.0, 4.0, 0.0), 2.0), Vec3::new(2.0, 1.0, 0.0));
        assert_eq!(bias.clamped, Entry { count: 1, energy: 3.0 });
        assert!(bias.clamp(Vec3::NAN, 1.0).is_nan());
        assert_eq!(bias.clamp(Vec3::INFINITY, 1.0), Vec3::INFINITY);
        assert_eq!(bias.clamped.count, 1);
    }
}
