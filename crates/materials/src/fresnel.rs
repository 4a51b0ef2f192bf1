//! Fresnel reflectance of smooth interfaces: the exact law for dielectrics, and Schlick's *approximation* as specified by
//! glTF. The formulas are those of [`crate::lanes`], for one direction.

use crate::lanes;
use glam::Vec3;

/// (1 − c)⁵ for c = |w·m| in 0..1: the weight of F90 over F0 in Schlick's *approximation* [Schlick 1994].
pub fn schlick_weight(c: f32) -> f32 {
    lanes::schlick_weight(c)
}

/// Reflectance at normal incidence ((η−1)/(η+1))², equal from both sides; 1 for η = 0 (`KHR_materials_ior`).
pub fn normal_reflectance(eta: f32) -> f32 {
    lanes::normal_reflectance(eta)
}

/// Unpolarised reflectance of a dielectric interface. `c` is the cosine on the near side (0..1), `eta` the far index
/// over the near index (> 0). 1 under total internal reflection.
pub fn dielectric(c: f32, eta: f32) -> f32 {
    lanes::dielectric(c, eta)
}

/// As [`dielectric`] with the cosines on both sides given: r_s = (c − η cₜ)/(c + η cₜ), r_p = (η c − cₜ)/(η c + cₜ), F
/// = (r_s² + r_p²)/2. Well conditioned at every angle and the same from both sides.
pub fn dielectric_between(c: f32, ct: f32, eta: f32) -> f32 {
    lanes::dielectric_between(c, ct, eta)
}

/// Snell's law for cosines: √((η−1)(η+1) + c²)/η; `None` under total internal reflection. The product keeps its
/// precision near η = 1 and does not overflow for η < 1e9.
pub fn far_cosine(c: f32, eta: f32) -> Option<f32> {
    let (ct, passes) = lanes::far_cosine(c, eta);
    passes.then_some(ct)
}

/// Direction refracted at `m` (wo·m = c > 0), with cosine `ct` on the far side: wi = (c/η − cₜ) m − wo/η.
pub fn refract(wo: Vec3, m: Vec3, c: f32, ct: f32, eta: f32) -> Vec3 {
    lanes::refract(wo.into(), m.into(), c, ct, eta).into()
}
