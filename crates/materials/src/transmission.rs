//! Transmission: refraction at a rough interface [Walter 2007], and blurred but unrefracted light through a thin wall.
//!
//! `f` is for radiance transported from `wi` to `wo`. Refraction compresses the solid angle of a beam, so radiance
//! changes by (η_o/η_i)², where η_o is the index on the side of `wo`. That factor is part of `f` and of the weights,
//! and [`crate::BsdfSample::eta`] holds its inverse (η_i/η_o)² so that Russian roulette can undo it. Reciprocity:
//! f(wo,wi)/η_o² is symmetric [Veach 1997, §5.2].
//!
//! Shadowing uses 1/(1 + Λ(wo) + Λ(wi)) for transmission as well as for reflection, as pbrt does: R + T ≤ 1 holds for
//! every facet.

use crate::Lobe;
use crate::fresnel::{Interface, far_cosine, refract};
use crate::microfacet::reflect;
use crate::reflection::Rough;
use glam::{Vec2, Vec3};

/// Cosines |w·m| of one facet with both directions.
#[derive(Clone, Copy, Debug)]
pub struct MicrofacetCosines {
    /// wo·m.
    pub o: f32,
    /// |wi·m|.
    pub i: f32,
}

/// Rough refraction for `wi.z` < 0, without its Fresnel factor. Returns D·G2-term with the Jacobian and 1/η², the pdf,
/// and the cosines of the facet.
pub fn eval_refraction(rough: &Rough, wo: Vec3, wi: Vec3, eta: f32) -> Option<(f32, f32, MicrofacetCosines)> {
    let m = (wo + wi * eta).try_normalize()?;
    let m = if m.z < 0.0 { -m } else { m };
    let facet = MicrofacetCosines { o: wo.dot(m), i: -wi.dot(m) };
    // A facet that faces away from either direction contributes nothing.
    if facet.o <= 0.0 || facet.i <= 0.0 {
        return None;
    }
    let ggx = rough.ggx;
    let denominator = facet.o / eta - facet.i;
    let d = 2.0 * ggx.d(m) * facet.o * facet.i / (denominator * denominator);
    let value = rough.gain() * d / (rough.t() * -wi.z + ggx.t(wi) * wo.z) / (eta * eta);
    Some((value, d / (wo.z + rough.t()), facet))
}

/// A sampled direction, its lobe, and the cosines of the facet that scattered it.
pub(crate) type Direction = (Vec3, Lobe, Option<MicrofacetCosines>);

/// Minimum probability q of either event at a facet, so that q and 1 − q keep their precision.
const LEAST_TURN: f32 = 1e-3;

/// A clear dielectric layer with its share of the material.
#[derive(Clone, Copy, Debug)]
pub struct ClearLayer {
    /// Weight of the reflection.
    pub share: f32,
    /// Base colour times the share: factor of transmitted light.
    pub tint: Vec3,
    /// Interface between the near and the far side.
    pub interface: Interface,
}

impl ClearLayer {
    /// For wi below the surface: f divided by tint and transmittance, the pdf of [`Self::facet`] and [`Self::leave`],
    /// and the reflectance of the facet that connects the two directions. `known`: the cosines of the facet, if they
    /// are known more accurately than from wi.
    pub fn eval(
        &self,
        rough: &Rough,
        wo: Vec3,
        wi: Vec3,
        known: Option<MicrofacetCosines>,
    ) -> Option<(f32, f32, Vec3)> {
        if self.interface.thin {
            let (value, pdf, c) = rough.eval(wo, Vec3::new(wi.x, wi.y, -wi.z));
            return Some((value, pdf, self.interface.reflectance(known.map_or(c, |facet| facet.o))));
        }
        let (value, pdf, found) = eval_refraction(rough, wo, wi, self.interface.eta)?;
        let facet = known.unwrap_or(found);
        Some((value, pdf, self.interface.reflectance_between(facet.o, facet.i)))
    }

    /// Samples a visible normal for transmission; from the bounded distribution if transmission mirrors `wo`.
    pub fn facet(&self, rough: &Rough, wo: Vec3, u: Vec2) -> Option<Vec3> {
        if self.interface.thin { rough.bounded_facet(wo, u) } else { rough.ggx.sample_visible(wo, u) }
    }

    /// Transmits through the facet `m`: mirrored to the other side by a thin wall, else refracted. `None` under total
    /// internal reflection and if the direction ends above the surface.
    pub fn leave(&self, wo: Vec3, m: Vec3) -> Option<Direction> {
        let c = wo.dot(m);
        let (wi, facet) = if self.interface.thin {
            let wi = reflect(wo, m);
            (Vec3::new(wi.x, wi.y, -wi.z), MicrofacetCosines { o: c, i: c })
        } else {
            let ct = far_cosine(c, self.interface.eta).filter(|_| c > 0.0)?;
            (refract(wo, m, c, ct, self.interface.eta), MicrofacetCosines { o: c, i: ct })
        };
        (wi.z < 0.0).then_some((wi, Lobe::GlossyTransmission, Some(facet)))
    }

    /// Probability that a facet reflects: reflected over total light at the facet; 1 under total internal reflection.
    pub fn reflecting(&self, reflectance: Vec3) -> f32 {
        let back = reflectance.element_sum() * self.share;
        let on = self.tint.element_sum() * (1.0 - reflectance.max_element());
        if on > 0.0 { (back / (back + on)).clamp(LEAST_TURN, 1.0 - LEAST_TURN) } else { 1.0 }
    }

    /// Weight of the delta lobe: tint·T·(η_o/η_i)².
    pub fn delta_weight(&self, wo: Vec3) -> Vec3 {
        self.tint * (self.interface.transmittance(wo.z) / self.interface.eta_squared())
    }

    /// Directional albedos of reflection and transmission, the latter without the factor 1/η², given the `c` of the
    /// lobe ([`crate::albedo::DirectionalAlbedo`]). *Approximation*: F at the macroscopic angle.
    pub fn albedos(&self, c: f32, mu: f32) -> [Vec3; 2] {
        let reflectance = self.interface.reflectance(mu);
        [reflectance * (self.share * c), self.tint * ((1.0 - reflectance.max_element()) * c)]
    }
}
