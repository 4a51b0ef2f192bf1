//! Light that goes through: bent at a rough interface [Walter 2007], or straight through a thin wall and blurred.
//!
//! `f` is for radiance carried from `wi` to `wo`. Refraction squeezes a beam's solid angle, so radiance changes by
//! (η_o/η_i)², where η_o is the index on the side of `wo`; that factor is in `f` and in the weights, and
//! [`crate::BsdfSample::eta`] holds its inverse (η_i/η_o)² so that roulette can undo it. Reciprocity reads
//! f(wo→wi) η_o⁻² … = f(wi→wo): f·η_o² is symmetric [Veach 1997, §5.2].
//!
//! Shadowing takes 1/(1 + Λ(wo) + Λ(wi)) for transmission as for reflection, as pbrt does: R + T ≤ 1 holds facet by facet.

use crate::albedo::Split;
use crate::fresnel::{Clear, refract};
use crate::microfacet::Ggx;
use crate::reflection::Rough;
use glam::{Vec2, Vec3};

/// Rough refraction without its Fresnel factor: (D·G2-term with the Jacobian and 1/η², pdf, wo·m). `wi.z` < 0.
pub fn eval_refraction(rough: &Rough, wo: Vec3, wi: Vec3, eta: f32) -> (f32, f32, f32) {
    const NOTHING: (f32, f32, f32) = (0.0, 0.0, 0.0);
    let Some(m) = (wo + wi * eta).try_normalize() else { return NOTHING };
    let m = if m.z < 0.0 { -m } else { m };
    let (co, ci) = (wo.dot(m), wi.dot(m));
    // A facet seen from behind by either direction takes no part.
    if co <= 0.0 || ci >= 0.0 {
        return NOTHING;
    }
    let ggx = rough.ggx;
    let denominator = ci + co / eta;
    let jacobian = -ci / (denominator * denominator);
    let d = 2.0 * ggx.d(m) * co * jacobian;
    let value = d / (rough.t() * -wi.z + ggx.t(wi) * wo.z) / (eta * eta);
    (value, d / (wo.z + rough.t()), co)
}

/// A direction bent at a visible normal, below the surface; `None` under total internal reflection.
pub fn sample_refraction(ggx: Ggx, wo: Vec3, u: Vec2, eta: f32) -> Option<Vec3> {
    let m = ggx.sample_visible(wo, u)?;
    let c = wo.dot(m);
    if c <= 0.0 {
        return None;
    }
    refract(wo, m, c, eta).filter(|wi| wi.z < 0.0)
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
    /// (f, pdf) for wi below the surface; zero for a delta lobe.
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let Some(rough) = &self.rough else { return (Vec3::ZERO, 0.0) };
        let (value, pdf, c) = if self.clear.thin {
            rough.eval(wo, Vec3::new(wi.x, wi.y, -wi.z))
        } else {
            eval_refraction(rough, wo, wi, self.clear.eta)
        };
        (self.tint * (self.clear.transmittance(c) * value), pdf)
    }

    /// A direction below the surface.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<Vec3> {
        match &self.rough {
            None if self.clear.goes_straight() => Some(-wo),
            None => refract(wo, Vec3::Z, wo.z, self.clear.eta).filter(|wi| wi.z < 0.0),
            Some(rough) if self.clear.thin => rough.sample(wo, u).map(|wi| Vec3::new(wi.x, wi.y, -wi.z)),
            Some(rough) => sample_refraction(rough.ggx, wo, u, self.clear.eta),
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
