//! The sum of lobes at one point, with eval / sample / pdf that agree.
use crate::{Lobe, Lobes, Material};
use glam::{Vec2, Vec3};
/// Ready to evaluate for one `wo`. Directions are unit, point away, local frame; wo.z may be negative (back side).
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {}
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    pub wi: Vec3,
    /// f·|cosθ_i| / pdf (mixture over the lobes asked for); never negative.
    pub weight: Vec3,
    /// Solid-angle density of the mixture; meaningless (1) for delta lobes.
    pub pdf: f32,
    pub lobe: Lobe,
    /// Ratio η_i/η_o squared factor for roulette: 1 for reflection.
    pub eta: f32,
}
impl Bsdf {
    /// `wo` local; `wo.z < 0` means the ray arrives at the back side.
    pub fn new(_material: &Material, _wo: Vec3) -> Self {
        todo!()
    }
    /// BSDF value without cosine, delta lobes excluded.
    pub fn f(&self, _wi: Vec3, _lobes: Lobes) -> Vec3 {
        todo!()
    }
    /// Solid-angle density of `sample_f` for the same lobes.
    pub fn pdf(&self, _wi: Vec3, _lobes: Lobes) -> f32 {
        todo!()
    }
    pub fn sample_f(&self, _uc: f32, _u: Vec2, _lobes: Lobes) -> Option<BsdfSample> {
        todo!()
    }
    /// Lobes that carry weight.
    pub fn lobes(&self) -> Lobes {
        todo!()
    }
    /// All delta: next-event estimation cannot help.
    pub fn is_delta(&self) -> bool {
        todo!()
    }
    /// Directional albedo estimate, for lobe choice and AOVs.
    pub fn albedo(&self) -> Vec3 {
        todo!()
    }
}
