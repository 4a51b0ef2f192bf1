//! Diffuse reflection, alone or under a specular coat.
//!
//! Alone it is Lambertian: f = ρ/π. Under a coat with directional albedo E it is
//! f = ρ/π · (1 − E(wo)) (1 − E(wi)) / (1 − E_mean), which is reciprocal and has an albedo of exactly ρ(1 − E(wo)):
//! base and coat together reflect no more than the incident light [Kelemen & Szirmay-Kalos 2001]. The sample
//! implementation of glTF uses (1 − F(wo·m)) instead, which adds up to more than 1 at grazing angles. For a
//! coloured coat the largest channel is subtracted from all (as in `KHR_materials_specular`), so no channel
//! gains energy.

use crate::albedo::AlbedoRow;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// The base is omitted if the mean transmittance of the coat is below this. *Approximation*: it loses at most this
/// share.
const SEALED: f32 = 1e-4;

/// The diffuse lobe for one `wo`.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse {
    /// ρ times the transmittance of the coat towards `wo`.
    albedo: Vec3,
    coat: Option<Coat>,
}

/// A coat over the base: the row of its albedo, F0 (largest channel) and F90, and 1/(1 − E_mean).
#[derive(Clone, Copy, Debug)]
struct Coat {
    row: AlbedoRow,
    f0: f32,
    f90: f32,
    scale: f32,
}

impl Diffuse {
    /// Lambertian reflection with reflectance ρ.
    pub fn bare(rho: Vec3) -> Self {
        Self { albedo: rho, coat: None }
    }

    /// Diffuse reflection under a Schlick coat; `None` if the coat transmits nothing. `mu` is the cosine of wo, and
    /// `gain` a factor of the reflection of the coat towards wo ([`crate::reflection::Rough::losing_as`]).
    pub fn coated(rho: Vec3, row: AlbedoRow, (f0, f90): (f32, f32), mu: f32, gain: f32) -> Option<Self> {
        let through = 1.0 - row.mean().with(f0, f90);
        if through < SEALED {
            return None;
        }
        let coat = Coat { row, f0, f90, scale: 1.0 / through };
        Some(Self { albedo: rho * coat.through(mu, gain), coat: Some(coat) })
    }

    /// BSDF value at the cosine `mu` > 0 of wi.
    pub fn f(&self, mu: f32) -> Vec3 {
        match &self.coat {
            None => self.albedo * FRAC_1_PI,
            Some(coat) => self.albedo * (FRAC_1_PI * coat.scale * coat.through(mu, 1.0)),
        }
    }

    /// f·cos/pdf for cosine-weighted sampling of wi.
    pub fn weight(&self, mu: f32) -> Vec3 {
        match &self.coat {
            None => self.albedo,
            Some(coat) => self.albedo * (coat.scale * coat.through(mu, 1.0)),
        }
    }

    /// Directional albedo of this lobe: exact.
    pub fn albedo(&self) -> Vec3 {
        self.albedo
    }
}

impl Coat {
    /// 1 − gain·E(μ), clamped to 0.
    fn through(&self, mu: f32, gain: f32) -> f32 {
        (1.0 - gain * self.row.at(mu).with(self.f0, self.f90)).max(0.0)
    }
}
