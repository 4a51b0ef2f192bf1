//! The integrals of the distribution ray tracer, each with its own sample set, or switched off.
//!
//! The path tracer samples all of them jointly and uses only whether each is off (count 0: the ideal limit).

use dapple_sampling::{Pattern, SampleSet};
use std::fmt;
use std::str::FromStr;

/// One of the integrals of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Effect {
    /// Antialiasing: the integral over the pixel area. Off: the pixel centre.
    Pixel,
    /// Depth of field: the integral over the lens. Off: a pinhole.
    Lens,
    /// Motion blur: the integral over the shutter interval. Off: the instant at which the shutter opens.
    Time,
    /// Soft shadows: the integral over each light. Off: all of its power from its centroid; an environment is
    /// unaffected.
    Light,
    /// Blurred reflections: the integral over the rough reflection lobe. Off: a mirror of reflectance F(θ).
    Glossy,
    /// Blurred refractions: the integral over the rough transmission lobe. Off: smooth refraction.
    Refract,
    /// Diffuse interreflection: the integral over the hemisphere. Off: only direct light.
    Diffuse,
}

impl Effect {
    /// All effects, with the names used by command-line options.
    pub const ALL: [(Self, &'static str); 7] = [
        (Self::Pixel, "pixel"),
        (Self::Lens, "lens"),
        (Self::Time, "time"),
        (Self::Light, "light"),
        (Self::Glossy, "glossy"),
        (Self::Refract, "refract"),
        (Self::Diffuse, "diffuse"),
    ];
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::ALL.iter().find(|(effect, _)| effect == self).map_or("", |(_, name)| name);
        f.write_str(name)
    }
}

/// Sample set of every integral. The default is that of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleSets {
    /// Samples over the pixel area.
    pub pixel: SampleSet,
    /// Samples over the lens.
    pub lens: SampleSet,
    /// Samples over the shutter interval; one-dimensional, with the total count of the set.
    pub time: SampleSet,
    /// Samples over each light: one punctual light, one environment, one emissive primitive.
    pub light: SampleSet,
    /// Samples over the rough reflection lobe.
    pub glossy: SampleSet,
    /// Samples over the rough transmission lobe.
    pub refract: SampleSet,
    /// Samples over the hemisphere.
    pub diffuse: SampleSet,
}

impl Default for SampleSets {
    fn default() -> Self {
        let stratified = |count| SampleSet::new(count, Pattern::Stratified);
        Self {
            pixel: stratified(16),
            lens: stratified(16),
            time: stratified(16),
            light: stratified(16),
            glossy: stratified(16),
            refract: stratified(1),
            diffuse: stratified(1),
        }
    }
}

impl SampleSets {
    /// The sample set of one effect.
    pub fn of(&self, effect: Effect) -> SampleSet {
        let mut copy = *self;
        *copy.of_mut(effect)
    }

    /// Mutable access to the sample set of one effect.
    pub fn of_mut(&mut self, effect: Effect) -> &mut SampleSet {
        match effect {
            Effect::Pixel => &mut self.pixel,
            Effect::Lens => &mut self.lens,
            Effect::Time => &mut self.time,
            Effect::Light => &mut self.light,
            Effect::Glossy => &mut self.glossy,
            Effect::Refract => &mut self.refract,
            Effect::Diffuse => &mut self.diffuse,
        }
    }

    /// Whether an effect is off.
    pub fn is_off(&self, effect: Effect) -> bool {
        self.of(effect).count() == 0
    }

    /// Applies `change` to every sample set that is not off.
    pub(crate) fn map(mut self, change: impl Fn(Effect, SampleSet) -> SampleSet) -> Self {
        for (effect, _) in Effect::ALL {
            let plan = self.of_mut(effect);
            if plan.count() > 0 {
                *plan = change(effect, *plan);
            }
        }
        self
    }
}

/// How the integrals are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Combine {
    /// Every inner integral is evaluated in full at every point of the outer integrals.
    #[default]
    Nested,
    /// As many samples as the pixel has points, each with one stratum of every integral; the strata are matched by
    /// random permutation [Cook 1984].
    Paired,
}

/// Error for an unknown combine mode.
#[derive(Clone, Debug, thiserror::Error)]
#[error("unknown combine mode '{0}' (expected nested or paired)")]
pub struct UnknownCombine(String);

impl FromStr for Combine {
    type Err = UnknownCombine;
    fn from_str(s: &str) -> Result<Self, UnknownCombine> {
        match s {
            "nested" => Ok(Self::Nested),
            "paired" => Ok(Self::Paired),
            _ => Err(UnknownCombine(s.into())),
        }
    }
}

impl fmt::Display for Combine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nested => "nested",
            Self::Paired => "paired",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_its_own_plan() {
        let mut plans = SampleSets::default();
        for (i, (effect, name)) in (100..).zip(Effect::ALL) {
            *plans.of_mut(effect) = SampleSet::new(i, Pattern::Random);
            assert_eq!(effect.to_string(), name);
        }
        for (i, (effect, _)) in (100..).zip(Effect::ALL) {
            assert_eq!(plans.of(effect).count(), i);
        }
        plans.time = SampleSet::OFF;
        assert!(plans.is_off(Effect::Time) && !plans.is_off(Effect::Lens));
    }
}
