//! Light that goes through: bent at a rough interface [Walter 2007], or straight through a thin wall and blurred.
//!
//! `f` is for radiance carried from `wi` to `wo`. Refraction squeezes a beam's solid angle, so radiance changes by
//! (η_o/η_i)², where η_o is the index on the side of `wo`; that factor is in `f` and in the weights, and
//! [`crate::BsdfSample::eta`] holds its inverse (η_i/η_o)² so that roulette can undo it. Reciprocity: f(wo,wi)/η_o² is
//! symmetric [Veach 1997, §5.2].
//!
//! Shadowing takes 1/(1 + Λ(wo) + Λ(wi)) for transmission as for reflection, as pbrt does: R + T ≤ 1 holds facet by facet.

use crate::Lobe;
use crate::fresnel::{Interface, far_cosine, refract};
use crate::microfacet::reflect;
use crate::reflection::Rough;
use glam::{Vec2, Vec3};

/// Cosines of one facet with both directions, |w·m|.
#[derive(Clone, Copy, Debug)]
pub struct MicrofacetCosines {
    /// wo·m.
    pub o: f32,
    /// |wi·m|.
    pub i: f32,
}

/// Rough refraction without its Fresnel factor: D·G2-term with the Jacobian and 1/η², pdf, facet. `wi.z` < 0.
pub fn eval_refraction(rough: &Rough, wo: Vec3, wi: Vec3, eta: f32) -> Option<(f32, f32, MicrofacetCosines)> {
    let m = (wo + wi * eta).try_normalize()?;
    let m = if m.z < 0.0 { -m } else { m };
    let facet = MicrofacetCosines { o: wo.dot(m), i: -wi.dot(m) };
    // A facet seen from behind by either direction takes no part.
    if facet.o <= 0.0 || facet.i <= 0.0 {
        return None;
    }
    let ggx = rough.ggx;
    let denominator = facet.o / eta - facet.i;
    let d = 2.0 * ggx.d(m) * facet.o * facet.i / (denominator * denominator);
    let value = rough.gain() * d / (rough.t() * -wi.z + ggx.t(wi) * wo.z) / (eta * eta);
    Some((value, d / (wo.z + rough.t()), facet))
}

/// A direction on its side of the surface, the lobe, and the facet that sent it there.
pub(crate) type Direction = (Vec3, Lobe, Option<MicrofacetCosines>);

/// A facet takes either way at least this often, so that q and 1 − q keep their digits.
const LEAST_TURN: f32 = 1e-3;

/// Matter that light goes through, with its share in the mix.
#[derive(Clone, Copy, Debug)]
pub struct ClearLayer {
    /// Of the reflection.
    pub share: f32,
    /// Base colour times the share, for what goes through.
    pub tint: Vec3,
    /// Between the near and the far side.
    pub interface: Interface,
}

impl ClearLayer {
    /// For wi below the surface: f over tint and transmittance, pdf of [`Self::facet`] and [`Self::leave`], and the
    /// reflectance of the facet that connects the two. `known`: the facet, where it is known better than from wi.
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

    /// A visible normal to leave by; bounded where leaving mirrors.
    pub fn facet(&self, rough: &Rough, wo: Vec3, u: Vec2) -> Option<Vec3> {
        if self.interface.thin { rough.bounded_facet(wo, u) } else { rough.ggx.sample_visible(wo, u) }
    }

    /// Through the facet `m`: mirrored to the other side by a thin wall, else bent; `None` under total internal reflection
    /// and where the way out is above the surface.
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

    /// Probability that a facet reflects: its share of what the facet sends anywhere; 1 under total internal reflection.
    pub fn reflecting(&self, reflectance: Vec3) -> f32 {
        let back = reflectance.element_sum() * self.share;
        let on = self.tint.element_sum() * (1.0 - reflectance.max_element());
        if on > 0.0 { (back / (back + on)).clamp(LEAST_TURN, 1.0 - LEAST_TURN) } else { 1.0 }
    }

    /// Weight of the delta lobe: tint·T·(η_o/η_i)².
    pub fn delta_weight(&self, wo: Vec3) -> Vec3 {
        self.tint * (self.interface.transmittance(wo.z) / self.interface.eta_squared())
    }

    /// Directional albedos of reflection and transmission, the latter without the factor 1/η², given the lobe's `c`
    /// ([`crate::albedo::DirectionalAlbedo`]). *Approximation*: F at the macroscopic angle.
    pub fn albedos(&self, c: f32, mu: f32) -> [Vec3; 2] {
        let reflectance = self.interface.reflectance(mu);
        [reflectance * (self.share * c), self.tint * ((1.0 - reflectance.max_element()) * c)]
    }
}
