//! One direction that a BSDF was sampled for, and which directions count as in the surface.

use crate::Lobe;
use glam::Vec3;

/// Cosines below this count as in the surface, where no light goes: f32 products of two of them end here.
pub(crate) const GRAZING: f32 = 1e-18;

/// One sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Local frame, unit, pointing away.
    pub wi: Vec3,
    /// f·|cosθ_i| / pdf (mixture over the lobes asked for); never negative.
    pub weight: Vec3,
    /// Solid-angle density of the mixture; meaningless (1) for delta lobes.
    pub pdf: f32,
    /// The lobe that was chosen.
    pub lobe: Lobe,
    /// (η_i/η_o)², the inverse of the radiance scaling in `weight`, for roulette: 1 for reflection and thin walls.
    pub eta: f32,
}
