//! How much of the light a rough coat reflects in all directions together: the directional albedo of the GGX lobe, from
//! a table.
//!
//! E(μ) = F0·C(μ,α) + (F90 − F0)·B(μ,α) for Schlick's Fresnel term. The table (see `examples/albedo_table.rs`) is bilinear
//! in (μ, roughness) and lies everywhere at or above the truth: *approximation*, by at most the lift its generator
//! prints. Its mean over the hemisphere is exact for the interpolant.

use crate::albedo_table::{MEAN, N, TABLE};
use crate::microfacet::SMOOTH_ALPHA;

/// A place between two rows of the table: one roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    index: u32,
    fraction: f32,
}

/// The two parts of a directional albedo: E = F0·`c` + (F90 − F0)·`b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// Albedo of the perfectly reflecting lobe.
    pub c: f32,
    /// Albedo weighted by (1 − wo·m)⁵.
    pub b: f32,
}

impl Row {
    /// The row of one α; smooth surfaces have their own, exact one.
    pub fn new(alpha: f32) -> Self {
        if alpha < SMOOTH_ALPHA {
            return Self { index: 0, fraction: 0.0 };
        }
        let x = (alpha.sqrt() * (N - 1) as f32).clamp(1.0, (N - 1) as f32);
        let index = (x as u32).min(N as u32 - 2);
        Self { index, fraction: x - index as f32 }
    }

    /// Albedo seen from cosine `mu` (0..1).
    pub fn at(self, mu: f32) -> Split {
        let mu = mu.clamp(0.0, 1.0);
        let i = ((mu.sqrt() * (N - 1) as f32) as usize).min(N - 2);
        let node = |i: usize| (i * i) as f32 * (1.0 / ((N - 1) * (N - 1)) as f32);
        // Rounding may leave μ an ulp outside its cell; extrapolating by an ulp is harmless.
        let x = (mu - node(i)) / (node(i + 1) - node(i));
        let j = self.index as usize;
        let part = |k: usize| {
            let row = |j: usize| TABLE[j][i][k] + x * (TABLE[j][i + 1][k] - TABLE[j][i][k]);
            row(j) + self.fraction * (row(j + 1) - row(j))
        };
        Split { c: part(0), b: part(1) }
    }

    /// 2∫₀¹ E(μ) μ dμ of the interpolant.
    pub fn mean(self) -> Split {
        let j = self.index as usize;
        let part = |k: usize| MEAN[j][k] + self.fraction * (MEAN[j + 1][k] - MEAN[j][k]);
        Split { c: part(0), b: part(1) }
    }
}
