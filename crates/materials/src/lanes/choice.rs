//! Selection of the layer that a sample follows, over lanes: by directional albedo, mean of the channels, at least 5 %
//! for each rough layer (smooth layers are selected exactly by their share).
//!
//! Rough clear dielectrics are one choice, not two: a visible facet is sampled, and it reflects with its own
//! probability R/(R + T), so that total internal reflection inside rough glass wastes no samples.

use crate::lobe::{Lobe, Lobes, meets};
use dapple_math::lanes::{Mask, Real, Word};

/// Minimum share of every live rough lobe before normalisation.
const LEAST_SHARE: f32 = 0.05;

/// The largest f32 below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Probability of each choice. They add up to 1, or are all zero if the given lobes carry no light.
#[derive(Clone, Copy, Debug)]
pub struct Shares<R> {
    /// The diffuse base.
    pub diffuse: R,
    /// Reflection that is not followed by a choice at the facet.
    pub reflection: R,
    /// Transmission without reflection.
    pub transmission: R,
    /// Facets of rough clear dielectrics, which then reflect or transmit.
    pub facets: R,
}

/// Index of no choice.
const NONE: u32 = 4;

/// The layer that a sample follows.
#[derive(Clone, Copy, Debug)]
pub struct Pick<R: Real> {
    /// Index of the choice, in the order of the fields of [`Shares`], or [`NONE`].
    choice: R::Word,
    /// Its probability; 0 if no lobe carries light.
    pub share: R,
    /// The random number, rescaled within the choice.
    pub rest: R,
}

/// A choice before normalisation: whether it is available, whether it is rough, and its albedo, summed over channels.
#[derive(Clone, Copy)]
struct Slot<R: Real> {
    chosen: R::Mask,
    rough: R::Mask,
    grey: R,
}

impl<R: Real> Shares<R> {
    /// The first argument holds the albedo of diffuse base, opaque reflection, clear reflection and transmission.
    /// `asked`: live lobes. `opaque`: whether any layer but the clear dielectric reflects. `clear`: whether there is a
    /// clear dielectric in any lane.
    #[inline(always)]
    pub fn new(grey: [R; 4], asked: R::Word, opaque: R::Mask, clear: bool) -> Self {
        let [diffuse, mirror, glass, through] = grey;
        let gloss = meets(asked, Lobes::of(Lobe::GlossyReflection));
        let reflects = gloss | meets(asked, Lobes::of(Lobe::DeltaReflection));
        let base = Slot {
            chosen: meets(asked, Lobes::of(Lobe::Diffuse)),
            rough: R::Mask::splat(true),
            grey: diffuse,
        };
        if !clear {
            let [diffuse, reflection] = shares([base, Slot { chosen: reflects, rough: gloss, grey: mirror }]);
            let none = R::splat(0.0);
            return Self { diffuse, reflection, transmission: none, facets: none };
        }
        let blur = meets(asked, Lobes::of(Lobe::GlossyTransmission));
        let transmits = blur | meets(asked, Lobes::of(Lobe::DeltaTransmission));
        let facets = gloss & blur;
        let [diffuse, reflection, transmission, facets] = shares([
            base,
            Slot {
                chosen: reflects & (!facets | opaque),
                rough: gloss,
                grey: R::select(facets, mirror, mirror + glass),
            },
            Slot { chosen: transmits & !facets, rough: blur, grey: through },
            Slot { chosen: facets, rough: facets, grey: glass + through },
        ]);
        Self { diffuse, reflection, transmission, facets }
    }

    /// Selects by `uc`: returns the choice, its probability, and `uc` rescaled within it. The last choice absorbs
    /// rounding errors.
    #[inline(always)]
    pub fn pick(&self, uc: R, clear: bool) -> Pick<R> {
        let zero = R::splat(0.0);
        let none = Pick { choice: R::Word::splat(NONE), share: zero, rest: zero };
        let mut offers = Offers { pick: none, left: uc, open: R::Mask::splat(true) };
        offers.next(0, self.diffuse);
        if offers.open.any() {
            offers.next(1, self.reflection);
        }
        if clear && offers.open.any() {
            offers.next(2, self.transmission);
            if offers.open.any() {
                offers.next(3, self.facets);
            }
        }
        let pick = offers.pick;
        Pick { rest: (pick.rest / pick.share).min(R::splat(BELOW_ONE)), ..pick }
    }
}

/// The choices up to some index: the one selected so far, what is left of the random number, and whether it goes on.
struct Offers<R: Real> {
    pick: Pick<R>,
    left: R,
    open: R::Mask,
}

impl<R: Real> Offers<R> {
    #[inline(always)]
    fn next(&mut self, index: u32, share: R) {
        let here = self.open & share.gt(R::splat(0.0));
        self.pick.choice = R::Word::select(here, R::Word::splat(index), self.pick.choice);
        self.pick.share = R::select(here, share, self.pick.share);
        self.pick.rest = R::select(here, self.left, self.pick.rest);
        self.open = self.open & !(here & self.left.lt(share));
        self.left = R::select(here, self.left - share, self.left);
    }
}

impl<R: Real> Pick<R> {
    /// Whether the choice has the given index.
    #[inline(always)]
    fn is(&self, index: u32) -> R::Mask {
        self.choice.eq(R::Word::splat(index))
    }

    /// The diffuse base.
    #[inline(always)]
    pub fn diffuse(&self) -> R::Mask {
        self.is(0)
    }

    /// Reflection without a choice at the facet.
    #[inline(always)]
    pub fn reflection(&self) -> R::Mask {
        self.is(1)
    }

    /// Transmission without reflection.
    #[inline(always)]
    pub fn transmission(&self) -> R::Mask {
        self.is(2)
    }

    /// Facets that reflect or transmit.
    #[inline(always)]
    pub fn facets(&self) -> R::Mask {
        self.is(3)
    }
}

/// Returns the probabilities of the choices.
#[inline(always)]
fn shares<R: Real, const N: usize>(slots: [Slot<R>; N]) -> [R; N] {
    let zero = R::splat(0.0);
    let mut sum = zero;
    for slot in slots {
        sum += R::select(slot.chosen, slot.grey, zero);
    }
    // The estimate may be zero although a rough lobe is not: refraction at the edge of total internal reflection.
    let least = R::select(sum.gt(zero), R::splat(LEAST_SHARE) * sum, R::splat(1.0));
    let (mut raised, mut sum) = ([zero; N], zero);
    for i in 0..N {
        let Slot { chosen, rough, grey } = slots[i];
        raised[i] = R::select(chosen, R::select(rough, grey.max(least), grey), zero);
        sum += raised[i];
    }
    let lit = sum.gt(zero) & sum.is_finite();
    for part in &mut raised {
        *part = R::select(lit, *part / sum, zero);
    }
    raised
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(lobes: Lobes) -> u32 {
        u32::from(lobes.0)
    }

    #[test]
    fn shares_add_up_and_the_choice_covers_the_unit_interval() {
        let asked = Lobes::of(Lobe::Diffuse).with(Lobe::GlossyReflection).with(Lobe::GlossyTransmission);
        let shares = Shares::<f32>::new([0.5, 0.001, 0.1, 0.2], bits(asked), true, true);
        let sum = shares.diffuse + shares.reflection + shares.transmission + shares.facets;
        assert!((sum - 1.0).abs() < 1e-6 && shares.transmission == 0.0);
        assert!(shares.reflection > 0.04, "raised to the minimum share: {shares:?}");
        let n = 100_000;
        let mut counts = [0.0f32; 4];
        for k in 0..n {
            let pick = shares.pick(k as f32 / n as f32, true);
            assert!(pick.share > 0.0, "a live lobe");
            assert!((0.0..1.0).contains(&pick.rest));
            counts[pick.choice as usize] += 1.0 / n as f32;
        }
        let wanted = [shares.diffuse, shares.reflection, shares.transmission, shares.facets];
        assert!(counts.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-3), "{counts:?} {wanted:?}");
    }

    #[test]
    fn a_lone_lobe_is_certain_and_none_is_none() {
        for clear in [true, false] {
            let lone = Shares::<f32>::new([1.0; 4], bits(Lobes::of(Lobe::DeltaReflection)), true, clear);
            assert_eq!(lone.reflection, 1.0);
            assert_eq!(Shares::<f32>::new([1.0; 4], 0, false, clear).pick(0.3, clear).share, 0.0);
        }
        // Transmission alone of a smooth dielectric under total internal reflection: there is none.
        let asked = bits(Lobes::of(Lobe::DeltaTransmission));
        assert_eq!(Shares::<f32>::new([0.0, 0.0, 1.0, 0.0], asked, false, true).pick(0.3, true).share, 0.0);
    }
}
