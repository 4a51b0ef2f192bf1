//! Extra layers: what the first hit saw, and how sure a pixel is.

use std::fmt;
use std::str::FromStr;

/// One layer of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Aov {
    /// The picture itself, linear radiance.
    Beauty,
    /// Directional albedo of the first hit (1: reflects everything), mean over the samples.
    Albedo,
    /// Unit shading normal of the first hit in world space, turned to the camera, mean over the samples.
    Normal,
    /// Distance from the camera's plane along the view axis, scene units; mean over the samples that hit.
    Depth,
    /// World-space position, scene units; mean over the samples that hit.
    Position,
    /// Variance of the pixel's mean, per channel (radiance²).
    Variance,
    /// Number of samples.
    SampleCount,
    /// Index of the object + 1 at the pixel's first sample, 0 = nothing; exact to 2^24.
    ObjectId,
    /// Index of the material + 1, likewise.
    MaterialId,
    /// What the [`crate::BiasReport`] holds of the pixel, per sample: radiance that the clamp took, throughput cut at the
    /// largest number of bounces and below 1e-30, and the share of samples that were not finite.
    Removed,
    /// Which objects and which materials the samples of a pixel first meet, and what share of it each covers: the layers
    /// `CryptoObject00` to `02` and `CryptoMaterial00` to `02` with their manifests [Friedman & Jones 2015].
    Cryptomatte,
}

impl Aov {
    /// All of them, with the name the command line and the EXR layer use.
    pub const ALL: [(Self, &'static str); 11] = [
        (Self::Beauty, "beauty"),
        (Self::Albedo, "albedo"),
        (Self::Normal, "normal"),
        (Self::Depth, "depth"),
        (Self::Position, "position"),
        (Self::Variance, "variance"),
        (Self::SampleCount, "samples"),
        (Self::ObjectId, "object"),
        (Self::MaterialId, "material"),
        (Self::Removed, "removed"),
        (Self::Cryptomatte, "cryptomatte"),
    ];

    /// Shows the first hit of each sample; the others show the picture, or say something about it.
    pub fn needs_first_hit(self) -> bool {
        !matches!(self, Self::Beauty | Self::Variance | Self::SampleCount | Self::Removed)
    }
}

impl fmt::Display for Aov {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::ALL.iter().find(|(aov, _)| aov == self).map_or("", |(_, name)| name);
        f.write_str(name)
    }
}

/// Not the name of a layer.
#[derive(Clone, Debug, thiserror::Error)]
#[error(
    "'{0}' is no layer; choose from beauty, albedo, normal, depth, position, variance, samples, object, material, removed, cryptomatte"
)]
pub struct UnknownAov(String);

impl FromStr for Aov {
    type Err = UnknownAov;
    fn from_str(s: &str) -> Result<Self, UnknownAov> {
        Self::ALL.iter().find(|(_, name)| *name == s).map(|(aov, _)| *aov).ok_or_else(|| UnknownAov(s.into()))
    }
}
