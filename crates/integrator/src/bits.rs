//! The version of the sample values.

/// Increases whenever a render of the same scene, settings and seed can give other bits than before, so that samples of
/// different versions are never combined unnoticed. It is written into the metadata of images.
///
/// | version | change |
/// |---|---|
/// | 1 | the first version |
/// | 2 | Russian roulette from the third reflection on, with four times the throughput as survival probability; sample points, BSDFs, lights and camera rays by formulas over lanes |
/// | 3 | sums of samples along a tree over their indices, so that parts of a render merge to the bits of the whole |
/// | 4 | tilted shading normals and environment maps by formulas over lanes |
/// | 5 | normal maps of surfaces that emit light, which version 4 applied twice in batches |
pub const BITS: i32 = 5;
