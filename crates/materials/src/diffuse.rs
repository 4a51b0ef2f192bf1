//! Light that goes into the base and comes out without direction, alone or under a specular coat.
//!
//! Alone: Lambert, f = ρ/π. Under a coat with directional albedo E:
//! f = ρ/π · (1 − E(wo)) (1 − E(wi)) / (1 − E_mean), which is reciprocal and whose albedo is exactly ρ(1 − E(wo)): base and
//! coat together reflect no more than arrives [Kelemen & Szirmay-Kalos 2001]. glTF's sample implementation takes
//! (1 − F(wo·m)) instead, which adds up to more than 1 at grazing angles. A coloured coat takes its largest channel from
//! all (as `KHR_materials_specular` does), so no channel gains.

use crate::albedo::AlbedoRow;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Below this share of light let through on average the base is left out. *Approximation*: it loses at most this share.
const SEALED: f32 = 1e-4;

/// The diffuse lobe seen from one `wo`.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse {
    /// ρ, times what the coat lets through on its way to `wo`.
    albedo: Vec3,
    coat: Option<Coat>,
}

/// A coat over the base: its albedo's row, F0 (largest channel) and F90, and 1/(1 − E_mean).
#[derive(Clone, Copy, Debug)]
struct Coat {
    row: AlbedoRow,
    f0: f32,
    f90: f32,
    scale: f32,
}

impl Diffuse {
    /// Lambert with reflectance ρ.
    pub fn bare(rho: Vec3) -> Self {
        Self { albedo: rho, coat: None }
    }

    /// Under a Schlick coat; `None` when the coat lets nothing through. `mu` = cosine of wo, `gain` on what the coat
    /// reflects towards it ([`crate::reflection::Rough::losing_as`]).
    pub fn coated(rho: Vec3, row: AlbedoRow, (f0, f90): (f32, f32), mu: f32, gain: f32) -> Option<Self> {
        let through = 1.0 - row.mean().with(f0, f90);
        if through < SEALED {
            return None;
        }
        let coat = Coat { row, f0, f90, scale: 1.0 / through };
        Some(Self { albedo: rho * coat.through(mu, gain), coat: Some(coat) })
    }

    /// The BSDF at cosine `mu` > 0 of wi.
    pub fn f(&self, mu: f32) -> Vec3 {
        match &self.coat {
            None => self.albedo * FRAC_1_PI,
            Some(coat) => self.albedo * (FRAC_1_PI * coat.scale * coat.through(mu, 1.0)),
        }
    }

    /// f·cos/pdf for cosine-weighted wi.
    pub fn weight(&self, mu: f32) -> Vec3 {
        match &self.coat {
            None => self.albedo,
            Some(coat) => self.albedo * (coat.scale * coat.through(mu, 1.0)),
        }
    }

    /// Share of the light that leaves by this lobe: exact.
    pub fn albedo(&self) -> Vec3 {
        self.albedo
    }
}

impl Coat {
    /// 1 − E(μ), the latter times `gain`.
    fn through(&self, mu: f32, gain: f32) -> f32 {
        (1.0 - gain * self.row.at(mu).with(self.f0, self.f90)).max(0.0)
    }
}
