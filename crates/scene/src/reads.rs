//! What a render looks at of surfaces: the rest need not be read, decoded or kept.

use crate::{AlphaMode, TexturedMaterial};

/// Uses that a render has for surfaces, beside where they are and the holes they have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reads {
    /// Light is shown: what surfaces emit, lamps, and what surrounds the scene.
    pub light: bool,
    /// Light is scattered: everything about reflection and transmission counts.
    pub scattering: bool,
    /// Albedo is shown.
    pub albedo: bool,
    /// Shading normals are shown.
    pub normals: bool,
    /// Keep even what nothing looks at, for comparison.
    pub everything: bool,
}

impl Default for Reads {
    /// Whatever light can do.
    fn default() -> Self {
        Self { light: true, scattering: true, albedo: true, normals: true, everything: false }
    }
}

impl Reads {
    /// All that files hold.
    pub const EVERYTHING: Self =
        Self { light: true, scattering: true, albedo: true, normals: true, everything: true };

    /// The parameters of reflection and transmission matter.
    pub fn matter(&self) -> bool {
        self.scattering || self.albedo || self.everything
    }

    /// Interpolated and mapped normals matter.
    pub fn shading_normals(&self) -> bool {
        self.matter() || self.normals
    }

    /// Whether the colour of a material counts: as what is reflected, or as a shadeless colour.
    pub(crate) fn color(&self, m: &TexturedMaterial) -> bool {
        self.matter() || (m.unlit && self.light)
    }

    /// Whether the base colour of a material counts: by its colour, or by its holes.
    pub(crate) fn base_color(&self, m: &TexturedMaterial) -> bool {
        self.color(m) || m.alpha_mode != AlphaMode::Opaque
    }
}
