//! Materials with textures, and their values at a hit.
use dapple_materials::Material;
use glam::{Affine2, Vec3};
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    #[default]
    Opaque,
    Mask {
        cutoff: f32,
    },
    Blend,
}
/// A texture, the uv set it uses and its KHR_texture_transform.
#[derive(Clone, Copy, Debug)]
pub struct TextureUse {
    pub texture: u32,
    pub uv_set: u32,
    pub transform: Option<Affine2>,
}
/// Factors (in `base`) times textures. Everything a glTF material says that we honour.
#[derive(Clone, Debug, Default)]
pub struct TexturedMaterial {
    pub name: String,
    pub base: Material,
    pub alpha: f32,
    pub alpha_mode: AlphaMode,
    /// Radiance factor: emissiveFactor × strength (W·m⁻²·sr⁻¹).
    pub emission: Vec3,
    pub double_sided: bool,
    pub unlit: bool,
    pub normal_scale: f32,
    /// Absorption coefficient per render unit (KHR_materials_volume); zero = clear.
    pub sigma_a: Vec3,
    pub base_color_texture: Option<TextureUse>,
    pub metallic_roughness_texture: Option<TextureUse>,
    pub normal_texture: Option<TextureUse>,
    pub emissive_texture: Option<TextureUse>,
    pub specular_texture: Option<TextureUse>,
    pub specular_color_texture: Option<TextureUse>,
    pub transmission_texture: Option<TextureUse>,
    // (further extensions add fields)
}
