//! Extra layers: what the first hit saw, and how sure a pixel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Aov {
    Albedo,
    Normal,
    Depth,
    Position,
    Variance,
    SampleCount,
    ObjectId,
    MaterialId,
}
// FromStr (albedo, normal, depth, position, variance, samples, object, material), Display, ALL
