//! BSDF samples.

use crate::lanes::Sample;
use crate::{Lobe, Lobes};
use glam::Vec3;

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Unit direction in the local frame, pointing away from the surface point.
    pub wi: Vec3,
    /// f·|cosθ_i| / pdf (mixture over the given lobes); never negative.
    pub weight: Vec3,
    /// Solid-angle density of the mixture; meaningless (1) for delta lobes.
    pub pdf: f32,
    /// The sampled lobe.
    pub lobe: Lobe,
    /// (η_i/η_o)², the inverse of the radiance scaling in `weight`, for Russian roulette: 1 for reflection and thin
    /// walls.
    pub eta: f32,
}

impl BsdfSample {
    /// The sample of one lane, if there is one.
    #[inline(always)]
    pub(crate) fn new(sample: Sample<f32>) -> Option<Self> {
        let lobe = Lobes(sample.lobe as u8).first()?;
        let (wi, weight) = (sample.wi.into(), sample.weight.into());
        Some(Self { wi, weight, pdf: sample.pdf, lobe, eta: sample.eta })
    }
}
