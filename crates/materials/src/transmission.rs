//! Light that goes through: bent at a rough interface [Walter 2007], or straight through a thin wall and blurred.
//!
//! `f` is for radiance carried from `wi` to `wo`. Refraction squeezes a beam's solid angle, so radiance changes by
//! (η_o/η_i)², where η_o is the index on the side of `wo`; that factor is in `f` and in the weights, and
//! [`crate::BsdfSample::eta`] holds its inverse (η_i/η_o)² so that roulette can undo it. Reciprocity: f(wo,wi)/η_o² is
//! symmetric [Veach 1997, §5.2].
//!
//! Shadowing takes 1/(1 + Λ(wo) + Λ(wi)) for transmission as for reflection, as pbrt does: R + T ≤ 1 holds facet by facet.

use crate::albedo::Split;
use crate::fresnel::{Clear, far_cosine, refract};
use crate::microfacet::Ggx;
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

/// A direction bent at a visible normal, below the surface; `None` under total internal reflection.
pub fn sample_refraction(ggx: Ggx, wo: Vec3, u: Vec2, eta: f32) -> Option<(Vec3, Facet)> {
    let m = ggx.sample_visible(wo, u)?;
    let c = wo.dot(m);
    let ct = far_cosine(c, eta).filter(|_| c > 0.0)?;
    let wi = refract(wo, m, c, ct, eta);
    (wi.z < 0.0).then_some((wi, Facet { o: c, i: ct }))
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
    /// (f, pdf) for wi below the surface; zero for a delta lobe. `known`: the facet, where it is known better than from wi.
    pub fn eval(&self, wo: Vec3, wi: Vec3, known: Option<Facet>) -> (Vec3, f32) {
        let evaluated = match &self.rough {
            None => None,
            Some(rough) if self.clear.thin => {
                let (value, pdf, c) = rough.eval(wo, Vec3::new(wi.x, wi.y, -wi.z));
                let c = known.map_or(c, |facet| facet.o);
                Some((value, pdf, self.clear.transmittance(c)))
            }
            Some(rough) => eval_refraction(rough, wo, wi, self.clear.eta).map(|(value, pdf, found)| {
                let facet = known.unwrap_or(found);
                (value, pdf, self.clear.transmittance_between(facet.o, facet.i))
            }),
        };
        evaluated.map_or((Vec3::ZERO, 0.0), |(value, pdf, through)| (self.tint * (through * value), pdf))
    }

    /// A direction below the surface, and the facet of a rough one.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<(Vec3, Option<Facet>)> {
        match &self.rough {
            None if self.clear.goes_straight() => Some((-wo, None)),
            None => {
                let ct = far_cosine(wo.z, self.clear.eta)?;
                Some((refract(wo, Vec3::Z, wo.z, ct, self.clear.eta), None))
            }
            Some(rough) if self.clear.thin => {
                rough.sample(wo, u).map(|(wi, c)| (Vec3::new(wi.x, wi.y, -wi.z), Some(Facet { o: c, i: c })))
            }
            Some(rough) => {
                sample_refraction(rough.ggx, wo, u, self.clear.eta).map(|(wi, facet)| (wi, Some(facet)))
            }
        }
    }

    /// Weight of the delta lobe: tint·T·(η_o/η_i)².
    pub fn delta_weight(&self, wo: Vec3) -> Vec3 {
        self.tint * (self.clear.transmittance(wo.z) / self.eta_squared())
    }

    /// (η_i/η_o)²: 1 where light keeps its direction.
    pub fn eta_squared(&self) -> f32 {
        if self.clear.goes_straight() { 1.0 } else { self.clear.eta * self.clear.eta }
    }

    /// Directional albedo, without the factor 1/η². *Approximation* (see [`Clear::mean_reflectance`]).
    pub fn albedo(&self, split: Split, alpha: f32, mu: f32) -> Vec3 {
        self.tint * ((1.0 - self.clear.mean_reflectance(alpha, mu).max_element()) * split.c)
    }
}
