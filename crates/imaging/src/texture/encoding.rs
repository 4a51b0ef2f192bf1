//! The encoding of texture values and the selection of channels.

/// The encoding of RGB values; alpha is linear in both cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// sRGB code values (base colour, emission).
    Srgb,
    /// Linear values in [0, 1] (normals, roughness, occlusion).
    Linear,
}

/// A set of the channels red, green, blue and alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channels(pub(super) [bool; 4]);

impl Channels {
    /// No channels.
    pub const NONE: Self = Self([false; 4]);
    /// Red.
    pub const R: Self = Self([true, false, false, false]);
    /// Green and blue.
    pub const GB: Self = Self([false, true, true, false]);
    /// Red, green and blue.
    pub const RGB: Self = Self([true, true, true, false]);
    /// Alpha.
    pub const A: Self = Self([false, false, false, true]);

    /// The union of two sets.
    pub fn or(self, other: Self) -> Self {
        Self(std::array::from_fn(|c| self.0[c] || other.0[c]))
    }
}
