//! What the numbers of a texture mean, and which of them are kept.

/// What the RGB bytes mean; alpha is linear in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// sRGB code values (base colour, emission).
    Srgb,
    /// Numbers in [0, 1] (normals, roughness, occlusion).
    Linear,
}

/// Which of red, green, blue and alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channels(pub(super) [bool; 4]);

impl Channels {
    /// None of them.
    pub const NONE: Self = Self([false; 4]);
    /// Red.
    pub const R: Self = Self([true, false, false, false]);
    /// Green and blue.
    pub const GB: Self = Self([false, true, true, false]);
    /// Colour.
    pub const RGB: Self = Self([true, true, true, false]);
    /// Alpha.
    pub const A: Self = Self([false, false, false, true]);

    /// Those of either.
    pub fn or(self, other: Self) -> Self {
        Self(std::array::from_fn(|c| self.0[c] || other.0[c]))
    }
}
