//! Selection of the surface data that a render uses; other data need not be read, decoded or kept.

use crate::{AlphaMode, TexturedMaterial};

/// Surface data that a render uses in addition to geometry and opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reads {
    /// Light is rendered: emission of surfaces, punctual lights and the environment.
    pub light: bool,
    /// Light is scattered: all parameters of reflection and transmission are used.
    pub scattering: bool,
    /// Albedo is output.
    pub albedo: bool,
    /// Shading normals are output.
    pub normals: bool,
    /// Unused data are kept as well, for comparison.
    pub everything: bool,
}

impl Default for Reads {
    /// Everything that light transport uses.
    fn default() -> Self {
        Self { light: true, scattering: true, albedo: true, normals: true, everything: false }
    }
}

impl Reads {
    /// Everything in a file, including unused data.
    pub const EVERYTHING: Self =
        Self { light: true, scattering: true, albedo: true, normals: true, everything: true };

    /// Whether parameters of reflection and transmission are used.
    pub fn matter(&self) -> bool {
        self.scattering || self.albedo || self.everything
    }

    /// Whether interpolated and mapped normals are used.
    pub fn shading_normals(&self) -> bool {
        self.matter() || self.normals
    }

    /// Whether the colour of a material is used, for reflection or as an unlit colour.
    pub(crate) fn color(&self, m: &TexturedMaterial) -> bool {
        self.matter() || (m.unlit && self.light)
    }

    /// Whether the base colour of a material is used, for its colour or its alpha.
    pub(crate) fn base_color(&self, m: &TexturedMaterial) -> bool {
        self.color(m) || m.alpha_mode != AlphaMode::Opaque
    }
}
