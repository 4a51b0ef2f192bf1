//! Bounds of the lobes that a material can have, over both sides and all angles.
//!
//! The renderer derives global properties of materials from these bounds: whether light sampling applies to a surface,
//! whether it transmits light without refraction, and how many lobes a ray can meet. [`crate::Bsdf::lobes`] is always a
//! subset of them.

use crate::lanes::{SHARP_BLUR, SMOOTH_ALPHA};
use crate::{Lobe, Lobes, Material, Mirror};
use glam::Vec3;

/// Indices that differ by less are treated as equal. [`crate::lanes::Interface`] uses half of this.
const EQUAL_INDICES: f32 = 2e-4;

/// Parameters that vary over a surface. Textures multiply factors, so each value lies between 0 and that of the
/// material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Varying {
    /// Metallic and roughness.
    pub metallic_roughness: bool,
    /// Transmission.
    pub transmission: bool,
    /// The index of refraction: where bodies touch, it is the ratio of their indices. That of thin walls is constant.
    pub ior: bool,
}

impl Varying {
    /// No parameter varies.
    pub const NOTHING: Self = Self { metallic_roughness: false, transmission: false, ior: false };
}

impl Material {
    /// Lobes that the material can have; it has no others at any point.
    pub fn lobe_bounds(&self, varying: Varying) -> Lobes {
        if let Some(mirror) = &self.mirror {
            return mirror.lobe_bounds();
        }
        let mut bounds = Lobes::NONE;
        let has_base = self.base_color.max(Vec3::ZERO) != Vec3::ZERO;
        if has_base && !self.is_metal(varying) && !self.is_clear(varying) {
            bounds = bounds.with(Lobe::Diffuse);
        }
        let alpha = self.roughness.clamp(0.0, 1.0) * self.roughness.clamp(0.0, 1.0);
        let rough = alpha >= SMOOTH_ALPHA;
        let smooth = !rough || varying.metallic_roughness;
        if self.reflects(varying) {
            bounds = if rough { bounds.with(Lobe::GlossyReflection) } else { bounds };
            bounds = if smooth { bounds.with(Lobe::DeltaReflection) } else { bounds };
        }
        if self.transmits(varying) {
            let bends = varying.ior || self.has_index() && self.index_contrast() > 0.0;
            let blurs = self.thin || bends;
            bounds = if rough && blurs { bounds.with(Lobe::GlossyTransmission) } else { bounds };
            let unbent = !self.thin && (varying.ior || self.keeps_direction());
            bounds = if smooth || unbent { bounds.with(Lobe::DeltaTransmission) } else { bounds };
        }
        bounds
    }

    /// Whether light can be transmitted.
    #[inline]
    pub fn transmits(&self, varying: Varying) -> bool {
        self.transmission > 0.0 && self.mirror.is_none() && !self.is_metal(varying)
    }

    /// Whether light transmitted by a smooth surface keeps its direction: through a thin wall, and where the index
    /// equals that of the outside or is unknown.
    #[inline]
    pub fn keeps_direction(&self) -> bool {
        self.thin || !self.has_index() || self.index_contrast() < EQUAL_INDICES
    }

    /// Whether any layer but the diffuse base reflects light.
    fn reflects(&self, varying: Varying) -> bool {
        let coated = self.specular > 0.0 && !self.is_clear(varying);
        self.metallic > 0.0 || coated || self.transmits(varying) && self.interface_reflects(varying)
    }

    /// Whether the surface of a clear dielectric reflects light at some angle. Towards a lower index it always does.
    fn interface_reflects(&self, varying: Varying) -> bool {
        if self.thin {
            return self.specular > 0.0 && self.has_interface() || self.has_index() && self.ior < 1.0;
        }
        varying.ior || self.has_interface() && (self.specular > 0.0 || self.has_index())
    }

    /// Whether the index differs from that of the outside by at least what either side of the surface may resolve.
    fn has_interface(&self) -> bool {
        !self.has_index() || self.index_contrast() >= 0.25 * EQUAL_INDICES
    }

    /// Whether the index is known: 0 in glTF means that it is not.
    #[inline]
    fn has_index(&self) -> bool {
        self.ior > 0.0
    }

    #[inline]
    fn index_contrast(&self) -> f32 {
        (self.ior - 1.0).abs()
    }

    #[inline]
    fn is_metal(&self, varying: Varying) -> bool {
        self.metallic >= 1.0 && !varying.metallic_roughness
    }

    /// Whether all light that enters the dielectric is transmitted.
    fn is_clear(&self, varying: Varying) -> bool {
        self.transmission >= 1.0 && !varying.transmission
    }
}

impl Mirror {
    fn lobe_bounds(&self) -> Lobes {
        match self {
            mirror if mirror.kr.max(Vec3::ZERO) == Vec3::ZERO => Lobes::NONE,
            mirror if mirror.blur >= SHARP_BLUR => Lobes::of(Lobe::Mirror),
            _ => Lobes::of(Lobe::DeltaReflection),
        }
    }
}

/// Access for other crates, which do not depend on the meaning of the fields.
impl Material {
    /// Whether the material is an infinitely thin wall.
    #[inline]
    pub fn is_thin(&self) -> bool {
        self.thin
    }

    /// Whether some light is transmitted at this point.
    #[inline]
    pub fn has_transmission(&self) -> bool {
        self.transmission > 0.0
    }

    /// Whether the surface is a mirror without a base, which lanes do not have.
    #[inline]
    pub fn is_mirror(&self) -> bool {
        self.mirror.is_some()
    }

    /// Whether the surface is smoother than the given perceptual roughness.
    pub fn is_smoother_than(&self, roughness: f32) -> bool {
        self.roughness < roughness
    }

    /// The base colour, the only visible property of an unlit surface.
    #[inline]
    pub fn base_color(&self) -> Vec3 {
        self.base_color
    }

    /// Replaces the index of refraction, for surfaces where two bodies touch.
    #[inline]
    pub fn set_ior(&mut self, ior: f32) {
        self.ior = ior;
    }
}
