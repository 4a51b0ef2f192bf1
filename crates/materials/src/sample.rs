//! BSDF samples, and the cosine below which directions count as lying in the surface.

use crate::Lobe;
use glam::Vec3;

/// Cosines below this count as in the surface, where no light is transported: the product of two of them reaches the
/// limit of f32.
pub(crate) const GRAZING: f32 = 1e-18;

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
