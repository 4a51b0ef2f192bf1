//! Which lobes can a material have, from whichever side and at whichever angle it is seen?
//!
//! What the whole of a render has to know of materials follows from these bounds: whether light can be aimed at a surface,
//! whether it lets light go straight on, how many lobes a ray meets. [`crate::Bsdf::lobes`] never leaves them.

use crate::microfacet::SMOOTH_ALPHA;
use crate::mirror::SHARP_BLUR;
use crate::{Lobe, Lobes, Material, Mirror};
use glam::Vec3;

/// Indices that differ by less are taken as equal. [`crate::fresnel::Interface`] does so for half of this.
const EQUAL_INDICES: f32 = 2e-4;

/// Values that differ from place to place on a surface. Textures multiply factors, so each lies between 0 and the
/// material's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Varying {
    /// Share of metal, and roughness.
    pub metallic_roughness: bool,
    /// Share of what goes through.
    pub transmission: bool,
    /// The index of refraction: where bodies touch, it is the ratio of theirs. That of thin walls stays.
    pub ior: bool,
}

impl Varying {
    /// The same values everywhere.
    pub const NOTHING: Self = Self { metallic_roughness: false, transmission: false, ior: false };
}

impl Material {
    /// Lobes that the material can have; it has no others, anywhere.
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

    /// Whether light can go through.
    #[inline]
    pub fn transmits(&self, varying: Varying) -> bool {
        self.transmission > 0.0 && self.mirror.is_none() && !self.is_metal(varying)
    }

    /// Whether light that goes through a smooth surface goes straight on: through a thin wall, and where the index is that of
    /// the outside, or not known.
    #[inline]
    pub fn keeps_direction(&self) -> bool {
        self.thin || !self.has_index() || self.index_contrast() < EQUAL_INDICES
    }

    /// Whether anything but the diffuse base reflects light.
    fn reflects(&self, varying: Varying) -> bool {
        let coated = self.specular > 0.0 && !self.is_clear(varying);
        self.metallic > 0.0 || coated || self.transmits(varying) && self.interface_reflects(varying)
    }

    /// Whether the surface of clear matter reflects light at some angle. Where the index falls it does so in any case.
    fn interface_reflects(&self, varying: Varying) -> bool {
        if self.thin {
            return self.specular > 0.0 && self.has_interface() || self.has_index() && self.ior < 1.0;
        }
        varying.ior || self.has_interface() && (self.specular > 0.0 || self.has_index())
    }

    /// Whether the index differs from that of the outside by as much as either side of the surface may see.
    fn has_interface(&self) -> bool {
        !self.has_index() || self.index_contrast() >= 0.25 * EQUAL_INDICES
    }

    /// Whether the index is known: glTF's 0 says that it is not.
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

    /// Whether all that enters the dielectric goes through.
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

/// Values that code above this crate reads or sets without knowing what else they decide.
impl Material {
    /// Whether it is an infinitely thin wall.
    #[inline]
    pub fn is_thin(&self) -> bool {
        self.thin
    }

    /// Whether some light goes through, at this very point.
    #[inline]
    pub fn has_transmission(&self) -> bool {
        self.transmission > 0.0
    }

    /// Whether its surface is smoother than one of this perceptual roughness.
    pub fn is_smoother_than(&self, roughness: f32) -> bool {
        self.roughness < roughness
    }

    /// The base colour, which is all that a shadeless surface shows.
    #[inline]
    pub fn base_color(&self) -> Vec3 {
        self.base_color
    }

    /// The same matter, met where the index of refraction is another one.
    #[inline]
    pub fn set_ior(&mut self, ior: f32) {
        self.ior = ior;
    }
}
