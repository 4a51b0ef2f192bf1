//! Directional albedo of the GGX reflection lobe, from a table: [`crate::lanes::AlbedoRow`] for one roughness.

use crate::lanes;

/// A position between two rows of the table, for one roughness, or a smooth surface.
#[derive(Clone, Copy, Debug)]
pub struct AlbedoRow(lanes::AlbedoRow<f32>);

/// The two parts of a directional albedo: E = F0·`c` + (F90 − F0)·`b`.
pub type DirectionalAlbedo = lanes::DirectionalAlbedo<f32>;

impl AlbedoRow {
    /// The row of one α.
    pub fn new(alpha: f32) -> Self {
        Self(lanes::AlbedoRow::new(alpha))
    }

    /// Directional albedo at the cosine `mu` (0..1).
    pub fn at(self, mu: f32) -> DirectionalAlbedo {
        self.0.at(mu)
    }

    /// 2∫₀¹ E(μ) μ dμ of the interpolant; 1 and 1/21 for smooth surfaces.
    pub fn mean(self) -> DirectionalAlbedo {
        self.0.mean()
    }
}
