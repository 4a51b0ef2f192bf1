//! All that the textures of a material say at a hit, for vertices that are computed over lanes.

use crate::Scene;
use dapple_geometry::Hit;
use dapple_materials::Material;
use glam::{Vec3, Vec4};

/// What a material has at a hit, apart from its geometry: all of its textures, looked up.
#[derive(Clone, Copy, Debug)]
pub struct Texels {
    /// Factors times textures.
    pub material: Material,
    /// Tangent with the sign of the bitangent in w; `None` without a normal map, or without tangents.
    pub tangent: Option<Vec4>,
    /// Unit normal of the normal map in tangent space; `None` where it is degenerate, and without a tangent.
    pub normal: Option<Vec3>,
    /// Emission of an emitting side.
    pub emission: Vec3,
}

impl Scene {
    /// Looks up the material of a hit, at seconds since the shutter opened.
    #[inline]
    pub fn texels(&self, hit: &Hit, time: f32) -> Texels {
        let (material, textured) = self.material_of(hit.object);
        let (accel, textures) = (&self.accel, &self.textures[..]);
        if !textured {
            let at = material.untextured(accel, hit);
            return Texels { material: at, tangent: None, normal: None, emission: material.emission };
        }
        let tangent = material.normal_texture.as_ref().and_then(|_| accel.tangent_at(hit, time));
        Texels {
            material: material.at(accel, textures, hit),
            tangent,
            normal: tangent.and_then(|_| material.normal(accel, textures, hit)),
            emission: material.radiance(accel, textures, hit),
        }
    }
}
