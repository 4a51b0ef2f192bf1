//! Selection of the layer that a sample follows: by directional albedo, mean of the channels, at least 5 % for each
//! rough layer (smooth layers are selected exactly by their share).
//!
//! Rough clear dielectrics are one choice, not two: a visible facet is sampled, and it reflects with its own
//! probability R/(R + T), so that total internal reflection inside rough glass wastes no samples.

use crate::{Lobe, Lobes};

/// Minimum share of every live rough lobe before normalisation.
const LEAST_SHARE: f32 = 0.05;

/// The largest f32 below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Probability of each choice. They add up to 1, or are all zero if the given lobes carry no light.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shares {
    pub diffuse: f32,
    pub reflection: f32,
    pub transmission: f32,
    /// Facets of rough clear dielectrics, which then reflect or transmit.
    pub facets: f32,
}

/// The layer that a sample follows.
#[derive(Clone, Copy)]
pub(crate) enum Choice {
    Diffuse,
    Reflection,
    Transmission,
    Facets,
}

impl Shares {
    /// The first argument holds the albedo of diffuse base, opaque reflection, clear reflection and transmission.
    /// `asked`: live lobes. `opaque`: whether any layer but the clear dielectric reflects.
    pub fn new([diffuse, mirror, clear, through]: [f32; 4], asked: Lobes, opaque: bool) -> Self {
        let (gloss, blur) =
            (asked.contains(Lobe::GlossyReflection), asked.contains(Lobe::GlossyTransmission));
        let reflects = gloss || asked.contains(Lobe::DeltaReflection);
        let transmits = blur || asked.contains(Lobe::DeltaTransmission);
        let facets = gloss && blur;
        // Selected, rough, grey albedo.
        let slots = [
            (asked.contains(Lobe::Diffuse), true, diffuse),
            (reflects && (!facets || opaque), gloss, if facets { mirror } else { mirror + clear }),
            (transmits && !facets, blur, through),
            (facets, true, clear + through),
        ];
        let sum: f32 = slots.iter().map(|&(chosen, _, grey)| if chosen { grey } else { 0.0 }).sum();
        // The estimate may be zero although a rough lobe is not: refraction at the edge of total internal reflection.
        let least = if sum > 0.0 { LEAST_SHARE * sum } else { 1.0 };
        let raised = slots.map(|(chosen, rough, grey)| match (chosen, rough) {
            (false, _) => 0.0,
            (true, false) => grey,
            (true, true) => grey.max(least),
        });
        let sum: f32 = raised.iter().sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return Self::default();
        }
        let [diffuse, reflection, transmission, facets] = raised.map(|part| part / sum);
        Self { diffuse, reflection, transmission, facets }
    }

    /// Selects by `uc`: returns the choice, its probability, and `uc` rescaled within it. The last choice absorbs
    /// rounding errors.
    pub fn pick(&self, uc: f32) -> Option<(Choice, f32, f32)> {
        let slots = [
            (Choice::Diffuse, self.diffuse),
            (Choice::Reflection, self.reflection),
            (Choice::Transmission, self.transmission),
            (Choice::Facets, self.facets),
        ];
        let (mut left, mut last) = (uc, None);
        for (choice, share) in slots {
            if share > 0.0 {
                last = Some((choice, share, (left / share).min(BELOW_ONE)));
                if left < share {
                    break;
                }
                left -= share;
            }
        }
        last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_and_the_choice_covers_the_unit_interval() {
        let asked = Lobes::of(Lobe::Diffuse).with(Lobe::GlossyReflection).with(Lobe::GlossyTransmission);
        let shares = Shares::new([0.5, 0.001, 0.1, 0.2], asked, true);
        let sum = shares.diffuse + shares.reflection + shares.transmission + shares.facets;
        assert!((sum - 1.0).abs() < 1e-6 && shares.transmission == 0.0);
        assert!(shares.reflection > 0.04, "raised to the minimum share: {shares:?}");
        let n = 100_000;
        let mut counts = [0.0f32; 4];
        for k in 0..n {
            let (choice, _, rest) = shares.pick(k as f32 / n as f32).expect("a live lobe");
            assert!((0.0..1.0).contains(&rest));
            counts[choice as usize] += 1.0 / n as f32;
        }
        let wanted = [shares.diffuse, shares.reflection, shares.transmission, shares.facets];
        assert!(counts.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-3), "{counts:?} {wanted:?}");
    }

    #[test]
    fn a_lone_lobe_is_certain_and_none_is_none() {
        let lone = Shares::new([1.0; 4], Lobes::of(Lobe::DeltaReflection), true);
        assert_eq!(lone.reflection, 1.0);
        assert!(Shares::new([1.0; 4], Lobes::NONE, false).pick(0.3).is_none());
        // Transmission alone of a smooth dielectric under total internal reflection: there is none.
        assert!(
            Shares::new([0.0, 0.0, 1.0, 0.0], Lobes::of(Lobe::DeltaTransmission), false).pick(0.3).is_none()
        );
    }
}
