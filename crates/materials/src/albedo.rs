//! Directional albedo of the GGX reflection lobe, from a table.
//!
//! E(μ) = F0·C(μ,α) + (F90 − F0)·B(μ,α) for Schlick's Fresnel term. Smooth surfaces have C = 1, B = (1 − μ)⁵. Rough
//! surfaces use a table (see `examples/albedo_table.rs`), bilinear in μ and roughness, whose values are nowhere below
//! the exact ones — *approximation*, above them by at most 0.005 — and whose mean over the hemisphere is exact for the
//! interpolant.

use crate::albedo_table::{MEAN, NX, NY, TABLE};
use crate::fresnel::schlick_weight;
use crate::microfacet::SMOOTH_ALPHA;

/// √1e-3, the roughness of the first row.
const R0: f32 = 0.031_622_78;

/// A position between two rows of the table, for one roughness. `None` for smooth surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlbedoRow(Option<(u32, f32)>);

/// The two parts of a directional albedo: E = F0·`c` + (F90 − F0)·`b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalAlbedo {
    /// Albedo of the perfectly reflecting lobe.
    pub c: f32,
    /// Albedo weighted by (1 − wo·m)⁵.
    pub b: f32,
}

impl DirectionalAlbedo {
    /// F0·c + (F90 − F0)·b.
    pub fn with(self, f0: f32, f90: f32) -> f32 {
        f0 * self.c + (f90 - f0) * self.b
    }

    /// Both parts times `gain`.
    pub fn times(self, gain: f32) -> Self {
        Self { c: gain * self.c, b: gain * self.b }
    }
}

impl AlbedoRow {
    /// The row of one α.
    pub fn new(alpha: f32) -> Self {
        if alpha < SMOOTH_ALPHA {
            return Self(None);
        }
        let roughness = |y: f32| R0 + (1.0 - R0) * (y / (NY - 1) as f32) * (y / (NY - 1) as f32);
        let r = alpha.min(1.0).sqrt();
        let y = ((r - R0).max(0.0) / (1.0 - R0)).sqrt() * (NY - 1) as f32;
        let j = (y as usize).min(NY - 2);
        let (low, high) = (roughness(j as f32), roughness((j + 1) as f32));
        Self(Some((j as u32, ((r - low) / (high - low)).clamp(0.0, 1.0))))
    }

    /// Directional albedo at the cosine `mu` (0..1).
    pub fn at(self, mu: f32) -> DirectionalAlbedo {
        let Some((j, fraction)) = self.0 else {
            return DirectionalAlbedo { c: 1.0, b: schlick_weight(mu) };
        };
        let mu = mu.clamp(0.0, 1.0);
        let i = ((mu.sqrt().sqrt() * (NX - 1) as f32) as usize).min(NX - 2);
        let node = |i: usize| {
            let x = i as f32 * (1.0 / (NX - 1) as f32);
            (x * x) * (x * x)
        };
        let x = ((mu - node(i)) / (node(i + 1) - node(i))).clamp(0.0, 1.0);
        let (low, high) = (&TABLE[j as usize], &TABLE[j as usize + 1]);
        let part = |k: usize| {
            let along = |row: &[[f32; 2]; NX]| row[i][k] + x * (row[i + 1][k] - row[i][k]);
            along(low) + fraction * (along(high) - along(low))
        };
        DirectionalAlbedo { c: part(0), b: part(1) }
    }

    /// 2∫₀¹ E(μ) μ dμ of the interpolant; 1 and 1/21 for smooth surfaces.
    pub fn mean(self) -> DirectionalAlbedo {
        let Some((j, fraction)) = self.0 else {
            return DirectionalAlbedo { c: 1.0, b: 1.0 / 21.0 };
        };
        let j = j as usize;
        let part = |k: usize| MEAN[j][k] + fraction * (MEAN[j + 1][k] - MEAN[j][k]);
        DirectionalAlbedo { c: part(0), b: part(1) }
    }
}
