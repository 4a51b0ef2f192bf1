//! Light that goes through: bent at a rough interface [Walter 2007], or straight through a thin wall and blurred.
//!
//! `f` is for radiance carried from `wi` to `wo`. Refraction squeezes a beam's solid angle, so radiance changes by
//! (η_o/η_i)², where η_o is the index on the side of `wo`; that factor is in `f` and in the weights, and
//! [`crate::BsdfSample::eta`] holds its inverse (η_i/η_o)² so that roulette can undo it. Reciprocity: f(wo,wi)/η_o² is
//! symmetric [Veach 1997, §5.2].
//!
//! Shadowing takes 1/(1 + Λ(wo) + Λ(wi)) for transmission as for reflection, as pbrt does: R + T ≤ 1 holds facet by facet.

use crate::Lobe;
use crate::albedo::Split;
use crate::fresnel::{Clear, far_cosine, refract};
use crate::microfacet::reflect;
use crate::reflection::Rough;
use glam::{Vec2, Vec3};

/// Cosines of one facet with both directions, |w·m|.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// wo·m.
    pub o: f32,
    /// |wi·m|.
    pub i: f32,
}

/// Rough refraction without its Fresnel factor: D·G2-term with the Jacobian and 1/η², pdf, facet. `wi.z` < 0.
pub fn eval_refraction(rough: &Rough, wo: Vec3, wi: Vec3, eta: f32) -> Option<(f32, f32, Facet)> {
    let m = (wo + wi * eta).try_normalize()?;
    let m = if m.z < 0.0 { -m } else { m };
    let facet = Facet { o: wo.dot(m), i: -wi.dot(m) };
    // A facet seen from behind by either direction takes no part.
    if facet.o <= 0.0 || facet.i <= 0.0 {
        return None;
    }
    let ggx = rough.ggx;
    let denominator = facet.o / eta - facet.i;
    let d = 2.0 * ggx.d(m) * facet.o * facet.i / (denominator * denominator);
    let value = d / (rough.t() * -wi.z + ggx.t(wi) * wo.z) / (eta * eta);
    Some((value, d / (wo.z + rough.t()), facet))
}

/// What goes through, seen from one `wo`: base colour times share, and the interface.
#[derive(Clone, Copy, Debug)]
pub struct Transmission {
    /// Base colour times the share of clear matter.
    pub tint: Vec3,
    /// The interface.
    pub clear: Clear,
    /// `None`: smooth, or a rough interface that does not bend light.
    pub rough: Option<Rough>,
}

impl Transmission {
    /// The lobe it is.
    pub fn lobe(&self) -> Lobe {
        if self.rough.is_some() { Lobe::GlossyTransmission } else { Lobe::DeltaTransmission }
    }

    /// For wi below the surface: f over tint and transmittance, pdf, and the reflectance of the facet that connects the
    /// two; `None` for a delta lobe. `known`: the facet, where it is known better than from wi.
    pub fn eval(&self, wo: Vec3, wi: Vec3, known: Option<Facet>) -> Option<(f32, f32, Vec3)> {
        let rough = self.rough.as_ref()?;
        if self.clear.thin {
            let (value, pdf, c) = rough.eval(wo, Vec3::new(wi.x, wi.y, -wi.z));
            return Some((value, pdf, self.clear.reflectance(known.map_or(c, |facet| facet.o))));
        }
        let (value, pdf, found) = eval_refraction(rough, wo, wi, self.clear.eta)?;
        let facet = known.unwrap_or(found);
        Some((value, pdf, self.clear.reflectance_between(facet.o, facet.i)))
    }

    /// A direction below the surface, and the facet of a rough one.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<(Vec3, Option<Facet>)> {
        let m = match &self.rough {
            None if self.clear.goes_straight() => return Some((-wo, None)),
            None => {
                let ct = far_cosine(wo.z, self.clear.eta)?;
                return Some((refract(wo, Vec3::Z, wo.z, ct, self.clear.eta), None));
            }
            Some(rough) if self.clear.thin => rough.bounded_facet(wo, u)?,
            Some(rough) => rough.ggx.sample_visible(wo, u)?,
        };
        self.leave(wo, m, wo.dot(m)).map(|(wi, facet)| (wi, Some(facet)))
    }

    /// Through the facet `m`, c = wo·m: mirrored to the other side by a thin wall, else bent; `None` under total internal
    /// reflection and where the way out is above the surface.
    pub fn leave(&self, wo: Vec3, m: Vec3, c: f32) -> Option<(Vec3, Facet)> {
        let (wi, facet) = if self.clear.thin {
            let wi = reflect(wo, m);
            (Vec3::new(wi.x, wi.y, -wi.z), Facet { o: c, i: c })
        } else {
            let ct = far_cosine(c, self.clear.eta).filter(|_| c > 0.0)?;
            (refract(wo, m, c, ct, self.clear.eta), Facet { o: c, i: ct })
        };
        (wi.z < 0.0).then_some((wi, facet))
    }

    /// Weight of the delta lobe: tint·T·(η_o/η_i)².
    pub fn delta_weight(&self, wo: Vec3) -> Vec3 {
        self.tint * (self.clear.transmittance(wo.z) / self.eta_squared())
    }

    /// (η_i/η_o)²: 1 where light keeps its direction.
    pub fn eta_squared(&self) -> f32 {
        if self.clear.goes_straight() { 1.0 } else { self.clear.eta * self.clear.eta }
    }

    /// Directional albedo, without the factor 1/η². *Approximation*: F at the macroscopic angle.
    pub fn albedo(&self, split: Split, mu: f32) -> Vec3 {
        self.tint * (self.clear.transmittance(mu) * split.c)
    }
}
