//! Transmission over lanes: refraction at a rough interface [Walter 2007], and blurred but unrefracted light through a
//! thin wall.
//!
//! `f` is for radiance transported from `wi` to `wo`. Refraction compresses the solid angle of a beam, so radiance
//! changes by (η_o/η_i)², where η_o is the index on the side of `wo`. That factor is part of `f` and of the weights,
//! and the `eta` of a sample holds its inverse (η_i/η_o)² so that Russian roulette can undo it. Reciprocity:
//! f(wo,wi)/η_o² is symmetric [Veach 1997, §5.2].
//!
//! Shadowing uses 1/(1 + Λ(wo) + Λ(wi)) for transmission as well as for reflection, as pbrt does: R + T ≤ 1 holds for
//! every facet.

use super::fresnel::{Interface, far_cosine, refract};
use super::microfacet::unit;
use super::reflection::Rough;
use dapple_math::lanes::{Mask, Real, Vec3x};

/// Cosines |w·m| of one facet with both directions.
#[derive(Clone, Copy, Debug)]
pub struct FacetCosines<R> {
    /// wo·m.
    pub o: R,
    /// |wi·m|.
    pub i: R,
}

impl<R: Real> FacetCosines<R> {
    /// Returns `yes` in the lanes of `mask` and `no` in the others.
    #[inline(always)]
    pub fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self { o: R::select(mask, yes.o, no.o), i: R::select(mask, yes.i, no.i) }
    }
}

/// What a direction below a rough surface carries.
#[derive(Clone, Copy, Debug)]
pub struct Transmission<R> {
    /// The BSDF value divided by the tint and by the transmittance of the facet.
    pub value: R,
    /// Density of the direction that leaves through a sampled facet, per solid angle.
    pub pdf: R,
    /// The facet that connects the two directions.
    pub facet: FacetCosines<R>,
}

/// Returns rough refraction for `wi.z` < 0, without its Fresnel factor: D·G2-term with the Jacobian and 1/η², and the
/// pdf. Both are 0 where no facet refracts `wi` to `wo`.
#[inline(always)]
pub fn eval_refraction<R: Real>(rough: &Rough<R>, wo: Vec3x<R>, wi: Vec3x<R>, eta: R) -> Transmission<R> {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let (m, found) = unit(wo + wi * eta);
    let m = Vec3x::select(m.z.lt(zero), -m, m);
    let facet = FacetCosines { o: wo.dot(m), i: -wi.dot(m) };
    // A facet that faces away from either direction contributes nothing.
    let faces = found & facet.o.gt(zero) & facet.i.gt(zero);
    if !faces.any() {
        return Transmission { value: zero, pdf: zero, facet };
    }
    let inverse = one / eta;
    let denominator = facet.o * inverse - facet.i;
    let d = R::splat(2.0) * rough.ggx.d(m) * facet.o * facet.i / (denominator * denominator);
    let value = rough.gain * d / (rough.t * -wi.z + rough.ggx.t(wi) * wo.z) * (inverse * inverse);
    let pdf = d / (wo.z + rough.t);
    Transmission { value: R::select(faces, value, zero), pdf: R::select(faces, pdf, zero), facet }
}

/// Minimum probability q of either event at a facet, so that q and 1 − q keep their precision.
const LEAST_TURN: f32 = 1e-3;

/// A clear dielectric layer with its share of the material.
#[derive(Clone, Copy, Debug)]
pub struct ClearLayer<R: Real> {
    /// Weight of the reflection.
    pub share: R,
    /// Base colour times the share: factor of transmitted light.
    pub tint: Vec3x<R>,
    /// Interface between the near and the far side.
    pub interface: Interface<R>,
}

impl<R: Real> ClearLayer<R> {
    /// For wi below the surface: what it carries, and the reflectance of the facet that connects the two directions.
    /// The pdf is that of a facet, bounded for thin walls, and [`Self::leave`]. `known`: the cosines of the facet, in
    /// the lanes where they are known more accurately than from wi.
    #[inline(always)]
    pub fn eval(
        &self,
        rough: &Rough<R>,
        wo: Vec3x<R>,
        wi: Vec3x<R>,
        known: Option<(R::Mask, FacetCosines<R>)>,
    ) -> (Transmission<R>, Vec3x<R>) {
        let thin = self.interface.thin;
        let mut all = if thin.all() {
            let zero = R::splat(0.0);
            Transmission { value: zero, pdf: zero, facet: FacetCosines { o: zero, i: zero } }
        } else {
            eval_refraction(rough, wo, wi, self.interface.eta)
        };
        if thin.any() {
            let wall = rough.eval(wo, Vec3x::new(wi.x, wi.y, -wi.z));
            let facet = FacetCosines { o: wall.cos, i: wall.cos };
            all.value = R::select(thin, wall.value, all.value);
            all.pdf = R::select(thin, wall.pdf, all.pdf);
            all.facet = FacetCosines::select(thin, facet, all.facet);
        }
        if let Some((mask, facet)) = known {
            all.facet = FacetCosines::select(mask, facet, all.facet);
        }
        (all, self.facet_reflectance(all.facet))
    }
    /// Returns the reflectance of a facet.
    #[inline(always)]
    fn facet_reflectance(&self, facet: FacetCosines<R>) -> Vec3x<R> {
        let interface = &self.interface;
        if !interface.thin.any() {
            return interface.reflectance_between(facet.o, facet.i);
        }
        let wall = interface.reflectance(facet.o);
        if interface.thin.all() {
            return wall;
        }
        Vec3x::select(interface.thin, wall, interface.reflectance_between(facet.o, facet.i))
    }

    /// Transmits through the facet `m` with wo·m = c: refracted, or through a thin wall to the other side of the
    /// direction `mirrored`, that of `wo` reflected at the facet. Returns the direction, whether light leaves there,
    /// and the cosines of the facet. It does not under total internal reflection and if the direction ends above the
    /// surface.
    #[inline(always)]
    pub fn leave(
        &self,
        wo: Vec3x<R>,
        m: Vec3x<R>,
        c: R,
        mirrored: Vec3x<R>,
    ) -> (Vec3x<R>, R::Mask, FacetCosines<R>) {
        let (zero, thin) = (R::splat(0.0), self.interface.thin);
        let mut wi = Vec3x::new(mirrored.x, mirrored.y, -mirrored.z);
        let (mut leaves, mut facet) = (thin, FacetCosines { o: c, i: c });
        if !thin.all() {
            let (ct, passes) = far_cosine(c, self.interface.eta);
            wi = Vec3x::select(thin, wi, refract(wo, m, c, ct, self.interface.eta));
            leaves = thin | (passes & c.gt(zero));
            facet.i = R::select(thin, c, ct);
        }
        (wi, leaves & wi.z.lt(zero), facet)
    }

    /// Returns the probability that a facet reflects: reflected over total light at the facet; 1 under total internal
    /// reflection.
    #[inline(always)]
    pub fn reflecting(&self, reflectance: Vec3x<R>) -> R {
        let one = R::splat(1.0);
        let back = sum(reflectance) * self.share;
        let on = sum(self.tint) * (one - reflectance.max_element());
        let q = (back / (back + on)).max(R::splat(LEAST_TURN)).min(R::splat(1.0 - LEAST_TURN));
        R::select(on.gt(R::splat(0.0)), q, one)
    }

    /// Returns the weight of the delta lobe: tint·T·(η_o/η_i)².
    #[inline(always)]
    pub fn delta_weight(&self, wo: Vec3x<R>) -> Vec3x<R> {
        self.tint * (self.interface.transmittance(wo.z) / self.interface.eta_squared())
    }

    /// Returns the directional albedos of reflection and transmission, the latter without the factor 1/η², given the
    /// `c` of the lobe ([`super::DirectionalAlbedo`]). *Approximation*: F at the macroscopic angle.
    #[inline(always)]
    pub fn albedos(&self, c: R, mu: R) -> [Vec3x<R>; 2] {
        let reflectance = self.interface.reflectance(mu);
        let through = (R::splat(1.0) - reflectance.max_element()) * c;
        [reflectance * (self.share * c), self.tint * through]
    }
}

/// Returns the sum of the channels.
#[inline(always)]
pub fn sum<R: Real>(color: Vec3x<R>) -> R {
    color.x + color.y + color.z
}
