//! Bias report: counts every deliberate bias (clamping, truncation, unreachable lights) with the energy it removed.
//!
//! A render with clean settings (roulette, no clamp, more bounces than paths take) has an empty report. Counting costs
//! time only where an event happens.

use dapple_math::ExactSum;
use dapple_scene::Scene;
use glam::Vec3;

/// Throughput below which a path ends: its remaining contribution is lost in the rounding of any image.
pub(crate) const FAINT: f32 = 1e-30;

/// Reason why a path was truncated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Truncation {
    /// The path reached `max_bounces`.
    Depth,
    /// The throughput fell below [`FAINT`].
    Faint,
    /// The path continues, but is inside more nested bodies than its medium stack can hold.
    Nested,
    /// A shadow ray crossed more transparent surfaces than allowed.
    Panes,
}

/// Number of events of one kind, and the energy that they removed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// Number of events.
    pub count: u64,
    /// Sum of the channel means. For clamped samples: radiance, summed over samples. For truncated paths: their
    /// throughput, which is the radiance lost if radiance 1 had arrived, because the actual incident radiance is
    /// unknown. NaN if it is not finite.
    pub energy: f64,
}

impl Entry {
    fn add(&mut self, energy: Vec3) {
        self.count += 1;
        self.energy += f64::from(energy.element_sum()) / 3.0;
    }
}

/// Events that biased the estimate. Non-finite samples are counted in [`crate::Stats`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BiasReport {
    /// Samples brighter than the clamp.
    pub clamped: Entry,
    /// Paths that ended at the maximum number of bounces although they could have continued.
    pub depth: Entry,
    /// Paths that ended because their throughput was below 1e-30.
    pub faint: Entry,
    /// Events in which a body was dropped from a full medium stack: throughput of the path.
    pub nested: Entry,
    /// Shadow rays lost because they crossed too many transparent surfaces: radiance that would have arrived if all of
    /// them had transmitted it.
    pub panes: Entry,
    /// Number of point, spot and distant lights whose light can reach a surface by specular reflection or refraction;
    /// no strategy samples that part of their light. An upper bound: whether the light reaches such surfaces is not
    /// checked.
    pub lights_unreachable: u64,
    /// Number of lights with nonzero power that are neither sampled nor hit by rays: zero, unless the power of a light
    /// overflows.
    pub lights_culled: u64,
}

/// Number of lights of `scene` that could contribute but are neither sampled nor hit.
pub(crate) fn culled(scene: &Scene) -> u64 {
    let aimed = |i: usize| scene.light_choice.as_ref().is_some_and(|choice| choice.contains(i));
    let hidden = scene.lights.iter().enumerate().filter(|&(i, light)| light.is_delta() && !aimed(i));
    hidden.filter(|(_, light)| light.power(1.0) != Vec3::ZERO).count() as u64
}

impl BiasReport {
    /// Whether no event was counted.
    pub fn is_clean(&self) -> bool {
        *self == Self::default()
    }

    /// Energies: clamped, truncated at the maximum number of bounces, faint.
    fn energies(&self) -> [f64; 3] {
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

    /// Scales `value` down, preserving its hue, until no channel exceeds `most`. A non-finite value is returned
    /// unchanged, and is counted as non-finite.
    pub(crate) fn clamp(&mut self, value: Vec3, most: f32) -> Vec3 {
        let largest = value.max_element();
        if !(largest > most && value.is_finite()) {
            return value;
        }
        let clamped = value * (most / largest);
        self.clamped.add(value - clamped);
        clamped
    }

    fn entries(&self) -> [Entry; 5] {
        [self.clamped, self.depth, self.faint, self.nested, self.panes]
    }
}

/// Sums of the bias reports of samples. The energy of each sample is rounded to f32 and then added exactly, so that the
/// order in which passes, tiles and threads add samples does not matter.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct BiasTotals([(u64, ExactSum); 5]);

impl BiasTotals {
    /// Adds the report of one sample.
    pub fn add(&mut self, sample: &BiasReport) {
        for (total, entry) in self.0.iter_mut().zip(sample.entries()) {
            total.0 += entry.count;
            total.1.add(entry.energy as f32);
        }
    }

    pub fn merge(&mut self, other: &Self) {
        for (total, other) in self.0.iter_mut().zip(&other.0) {
            total.0 += other.0;
            total.1.merge(&other.1);
        }
    }

    /// The report, without the entries that do not come from samples.
    pub fn report(&self) -> BiasReport {
        let [clamped, depth, faint, nested, panes] =
            std::array::from_fn(|i| Entry { count: self.0[i].0, energy: self.0[i].1.value() });
        BiasReport { clamped, depth, faint, nested, panes, ..BiasReport::default() }
    }
}

/// Sums over the samples of a pixel, for the layer that shows them; exact as in [`BiasTotals`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Removed {
    energies: [ExactSum; 3],
    not_finite: u64,
}

impl Removed {
    /// Adds the report of one sample, which may be non-finite.
    pub fn add(&mut self, sample: &BiasReport, finite: bool) {
        self.not_finite += u64::from(!finite);
        if !sample.is_clean() {
            self.energies.iter_mut().zip(sample.energies()).for_each(|(sum, energy)| sum.add(energy as f32));
        }
    }

    pub fn merge(&mut self, other: &Self) {
        self.not_finite += other.not_finite;
        self.energies.iter_mut().zip(&other.energies).for_each(|(sum, other)| sum.merge(other));
    }

    /// Energies: clamped, truncated at the maximum number of bounces, faint; and the number of non-finite samples.
    pub fn energies(&self) -> [f64; 4] {
        let [clamped, depth, faint] = self.energies.map(|sum| sum.value());
        [clamped, depth, faint, self.not_finite as f64]
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
