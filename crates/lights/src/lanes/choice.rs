//! Selection of one light per lane.
use super::columns::{lane, lanes_of, stored, three};
use crate::LightSampler;
use crate::descent::Receivers;
use dapple_math::lanes::{MAX_LANES, Mask, Real, Vec3x, Word};

/// One selected light per lane.
#[derive(Clone, Copy, Debug)]
pub struct Chosen<R: Real> {
    /// Scene index of the light.
    pub index: R::Word,
    /// Probability of the selection; 0 outside of the active lanes.
    pub pmf: R,
    /// The number it was selected by, rescaled to \[0, 1).
    pub u: R,
}

impl<R: Real> Chosen<R> {
    /// Selects a light for receivers at `p` with normals `n` by the numbers `uc` in \[0, 1), as [`LightSampler::sample`]
    /// does, in the lanes of `active`. In scenes with infinite lights, receivers are taken one by one, and the lanes
    /// weigh the lights, or the children of a node of the light tree, of one receiver.
    #[inline(always)]
    pub fn new(sampler: &LightSampler, active: R::Mask, p: Vec3x<R>, n: Vec3x<R>, uc: R) -> Self {
        if let Some(light) = sampler.only() {
            let pmf = R::select(active, R::splat(1.0), R::splat(0.0));
            return Self { index: R::Word::splat(light), pmf, u: uc };
        }
        if R::LANES > 1
            && let Some((index, pmf, u)) = sampler.chosen_lanes(active, &Receivers { p, n }, uc)
        {
            return Self { index, pmf, u };
        }
        let (p, n, [uc]) = (three(p), three(n), stored([uc]));
        let (mut index, mut pmf, mut u) = ([0; MAX_LANES], [0.0; MAX_LANES], [0.0; MAX_LANES]);
        for i in lanes_of(active.bitmask()) {
            let choice = sampler.chosen::<R>(lane(&p, i), lane(&n, i), uc[i]);
            (index[i], pmf[i], u[i]) = (choice.index as u32, choice.pmf, choice.u);
        }
        Self { index: R::Word::load(&index), pmf: R::load(&pmf), u: R::load(&u) }
    }
}

/// Probabilities with which [`Chosen::new`] selects the lights `index`: the same bits as in the selection; 0 outside of
/// the lanes of `active`.
#[inline(always)]
pub fn probabilities<R: Real>(
    sampler: &LightSampler,
    active: R::Mask,
    p: Vec3x<R>,
    n: Vec3x<R>,
    index: R::Word,
) -> R {
    if let Some(light) = sampler.only() {
        let is_it = active & index.eq(R::Word::splat(light));
        return R::select(is_it, R::splat(1.0), R::splat(0.0));
    }
    if R::LANES > 1
        && let Some(pmf) = sampler.probability_lanes(active, &Receivers { p, n }, index)
    {
        return pmf;
    }
    let (p, n, mut numbers) = (three(p), three(n), [0; MAX_LANES]);
    index.store(&mut numbers);
    let mut pmf = [0.0; MAX_LANES];
    for i in lanes_of(active.bitmask()) {
        pmf[i] = sampler.probability::<R>(lane(&p, i), lane(&n, i), numbers[i] as usize);
    }
    R::load(&pmf)
}
