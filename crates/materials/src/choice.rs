//! Which layer a sample follows: by directional albedo, mean of the channels, at least 5 % for each rough layer (smooth
//! ones weigh exactly what their share says).
//!
//! Rough clear matter is one choice, not two: a visible facet is drawn, and that facet reflects with probability
//! R/(R + T) of its own, so that total reflection inside rough glass wastes nothing.

use crate::{Lobe, Lobes};

/// Every live rough lobe is chosen at least this often before normalising.
const LEAST_SHARE: f32 = 0.05;

/// The largest f32 below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Probability of each choice; they add up to 1, or are all zero when the lobes asked for carry nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shares {
    pub diffuse: f32,
    pub reflection: f32,
    pub transmission: f32,
    /// Facets of rough clear matter, which then reflect or transmit.
    pub facets: f32,
}

/// What a sample follows.
#[derive(Clone, Copy)]
pub(crate) enum Choice {
    Diffuse,
    Reflection,
    Transmission,
    Facets,
}

impl Shares {
    /// `grey`: albedo of diffuse base, opaque reflection, clear reflection, transmission. `asked`: live lobes.
    /// `opaque`: whether anything but clear matter reflects.
    pub fn new([diffuse, mirror, clear, through]: [f32; 4], asked: Lobes, opaque: bool) -> Self {
        let (gloss, blur) =
            (asked.contains(Lobe::GlossyReflection), asked.contains(Lobe::GlossyTransmission));
        let reflects = gloss || asked.contains(Lobe::DeltaReflection);
        let transmits = blur || asked.contains(Lobe::DeltaTransmission);
        let facets = gloss && blur;
        // Chosen, rough, grey albedo.
        let slots = [
            (asked.contains(Lobe::Diffuse), true, diffuse),
            (reflects && (!facets || opaque), gloss, if facets { mirror } else { mirror + clear }),
            (transmits && !facets, blur, through),
            (facets, true, clear + through),
        ];
        let sum: f32 = slots.iter().map(|&(chosen, _, grey)| if chosen { grey } else { 0.0 }).sum();
        // The estimate may be zero where a rough lobe is not: refraction at the edge of total reflection.
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

    /// The choice at `uc`, its share, and `uc` stretched over it; the last one takes what rounding leaves.
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
        assert!(shares.reflection > 0.04, "raised to the least share: {shares:?}");
        let n = 100_000;
        let mut counts = [0.0f32; 4];
        for k in 0..n {
            let (choice, _, rest) = shares.pick(k as f32 / n as f32).expect("something is live");
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
        // Smooth matter under total reflection: asked for transmission alone, it has none.
        assert!(
            Shares::new([0.0, 0.0, 1.0, 0.0], Lobes::of(Lobe::DeltaTransmission), false).pick(0.3).is_none()
        );
    }
}
