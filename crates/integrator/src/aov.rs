//! Arbitrary output variables: properties of the first hit, and statistics of the pixel estimates.

use std::fmt;
use std::str::FromStr;

/// One layer of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Aov {
    /// The image itself, linear radiance.
    Beauty,
    /// Directional albedo of the first hit (1: reflects everything), mean over the samples.
    Albedo,
    /// Unit shading normal of the first hit in world space, facing the camera, mean over the samples.
    Normal,
    /// Distance from the camera plane along the view axis, in scene units; mean over the samples that hit a surface.
    Depth,
    /// World-space position, in scene units; mean over the samples that hit a surface.
    Position,
    /// Variance of the pixel mean, per channel (radiance²).
    Variance,
    /// Number of samples.
    SampleCount,
    /// Object index + 1 at the pixel's first sample, 0 where nothing is hit; exact to 2^24.
    ObjectId,
    /// Material index + 1 at the pixel's first sample, 0 where nothing is hit; exact to 2^24.
    MaterialId,
    /// Entries of the [`crate::BiasReport`] for the pixel, per sample: radiance removed by the clamp, throughput cut at
    /// the maximum number of bounces and below 1e-30, and the share of non-finite samples.
    Removed,
    /// The objects and materials at the first hits of a pixel's samples, each with the share of the pixel that it
    /// covers: the layers `CryptoObject00` to `02` and `CryptoMaterial00` to `02` with their manifests [Friedman &
    /// Jones 2015].
    Cryptomatte,
}

impl Aov {
    /// All layers, with the names used on the command line and for EXR layers.
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

    /// Whether the layer shows the first hit of each sample; the other layers show the image or statistics of it.
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

/// Error for an unknown layer name.
#[derive(Clone, Debug, thiserror::Error)]
#[error(
    "unknown layer '{0}' (expected beauty, albedo, normal, depth, position, variance, samples, object, material, removed, cryptomatte or all)"
)]
pub struct UnknownAov(String);

impl FromStr for Aov {
    type Err = UnknownAov;
    fn from_str(s: &str) -> Result<Self, UnknownAov> {
        Self::ALL.iter().find(|(_, name)| *name == s).map(|(aov, _)| *aov).ok_or_else(|| UnknownAov(s.into()))
    }
}
