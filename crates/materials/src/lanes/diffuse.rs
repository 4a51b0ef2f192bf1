//! Diffuse reflection over lanes, alone or under a specular coat.
//!
//! Alone it is Lambertian: f = ρ/π. Under a coat with directional albedo E it is
//! f = ρ/π · (1 − E(wo)) (1 − E(wi)) / (1 − E_mean), which is reciprocal and has an albedo of exactly ρ(1 − E(wo)):
//! base and coat together reflect no more than the incident light [Kelemen & Szirmay-Kalos 2001]. The sample
//! implementation of glTF uses (1 − F(wo·m)) instead, which adds up to more than 1 at grazing angles. For a
//! coloured coat the largest channel is subtracted from all (as in `KHR_materials_specular`), so no channel
//! gains energy.

use super::albedo::{AlbedoRow, DirectionalAlbedo};
use dapple_math::lanes::{Mask, Real, Vec3x};
use std::f32::consts::FRAC_1_PI;

/// The base is omitted if the mean transmittance of the coat is below this. *Approximation*: it loses at most this
/// share.
const SEALED: f32 = 1e-4;

/// The diffuse lobe for one `wo`; black where there is none.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse<R: Real> {
    /// ρ times the transmittance of the coat towards `wo`: the directional albedo of this lobe, exact.
    pub albedo: Vec3x<R>,
    coated: R::Mask,
    coat: Coat<R>,
}

/// A coat over the base: the row of its albedo, F0 (largest channel) and F90, and 1/(1 − E_mean).
#[derive(Clone, Copy, Debug)]
struct Coat<R: Real> {
    row: AlbedoRow<R>,
    f0: R,
    f90: R,
    scale: R,
}

impl<R: Real> Diffuse<R> {
    /// Builds diffuse reflection with reflectance ρ, where `coated` under a Schlick coat of the given F0 and F90; it is
    /// black where the coat transmits nothing. `towards` is the directional albedo of the coat towards wo,
    /// [`AlbedoRow::at`] times a factor of the reflection of the coat.
    #[inline(always)]
    pub fn new(
        rho: Vec3x<R>,
        coated: R::Mask,
        row: AlbedoRow<R>,
        (f0, f90): (R, R),
        towards: DirectionalAlbedo<R>,
    ) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let none = Coat { row, f0, f90, scale: one };
        if !coated.any() {
            return Self { albedo: rho, coated, coat: none };
        }
        let through = one - row.mean().with(f0, f90);
        let open = !coated | through.ge(R::splat(SEALED));
        let coat = Coat { scale: R::select(coated & open, one / through, one), ..none };
        let towards = R::select(coated, coat.remainder(towards), one);
        Self { albedo: rho * R::select(open, towards, zero), coated, coat }
    }

    /// Returns the BSDF value at the cosine `mu` > 0 of wi.
    #[inline(always)]
    pub fn f(&self, mu: R) -> Vec3x<R> {
        self.albedo * (R::splat(FRAC_1_PI) * self.out(mu))
    }

    /// Returns f·cos/pdf for cosine-weighted sampling of wi.
    #[inline(always)]
    pub fn weight(&self, mu: R) -> Vec3x<R> {
        self.albedo * self.out(mu)
    }

    /// Returns the transmittance of the coat towards wi over its mean; 1 without a coat.
    #[inline(always)]
    fn out(&self, mu: R) -> R {
        let one = R::splat(1.0);
        if !self.coated.any() {
            return one;
        }
        let through = self.coat.scale * self.coat.remainder(self.coat.row.at(mu));
        R::select(self.coated, through, one)
    }
}

impl<R: Real> Coat<R> {
    /// Returns 1 − E, clamped to 0.
    #[inline(always)]
    fn remainder(&self, albedo: DirectionalAlbedo<R>) -> R {
        (R::splat(1.0) - albedo.with(self.f0, self.f90)).max(R::splat(0.0))
    }
}
