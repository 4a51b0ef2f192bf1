//! Materials with textures.
//!
//! A value is its factor times its texture; a base colour is multiplied by the vertex colour COLOR_0 as well.
use dapple_materials::Material;
use glam::{Affine2, Vec2, Vec3, Vec4};

/// What the alpha of the base colour means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Nothing: the surface is solid.
    #[default]
    Opaque,
    /// Solid where alpha ≥ cutoff, absent elsewhere.
    Mask {
        /// Smallest alpha that counts as solid.
        cutoff: f32,
    },
    /// Covers the fraction alpha of what lies behind.
    Blend,
}

/// A texture, the uv set it uses and its KHR_texture_transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Index into the scene's textures.
    pub texture: u32,
    /// TEXCOORD_0 or TEXCOORD_1.
    pub uv_set: u32,
    /// Applied to uv before the lookup; None is the identity.
    pub transform: Option<Affine2>,
}

impl TextureUse {
    /// The whole texture by the first uv set.
    pub fn new(texture: u32) -> Self {
        Self { texture, uv_set: 0, transform: None }
    }

    /// uv as the texture sees it.
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        self.transform.map_or(uv, |t| t.matrix2 * uv + t.translation)
    }
}

/// Factors (in `base`) times textures: everything a glTF material says that dapple honours.
#[derive(Clone, Debug)]
pub struct TexturedMaterial {
    /// For reports and AOVs.
    pub name: String,
    /// Factors.
    pub base: Material,
    /// Alpha factor of the base colour.
    pub alpha: f32,
    /// What alpha means.
    pub alpha_mode: AlphaMode,
    /// Radiance factor: emissiveFactor × strength (W·m⁻²·sr⁻¹).
    pub emission: Vec3,
    /// Emits from both sides; not removed by back-face culling.
    pub double_sided: bool,
    /// Shadeless: shows its base colour as radiance, to both sides, and scatters nothing. It is seen by the camera, directly
    /// and by way of mirrors and clear glass, and lights nothing.
    pub unlit: bool,
    /// Multiplies the x and y of the normal map.
    pub normal_scale: f32,
    /// Absorption coefficient of the inside: per world unit in the builder, per render unit in the scene; zero = clear.
    pub sigma_a: Vec3,
    /// Where volumes overlap, the one of the highest priority is there (see [`crate::Bodies`]); any finite number.
    pub priority: f64,
    /// rgb × base colour, a × alpha.
    pub base_color_texture: Option<TextureUse>,
    /// g × roughness, b × metallic.
    pub metallic_roughness_texture: Option<TextureUse>,
    /// Tangent-space normals, +y up.
    pub normal_texture: Option<TextureUse>,
    /// rgb × emission.
    pub emissive_texture: Option<TextureUse>,
    /// a × specular.
    pub specular_texture: Option<TextureUse>,
    /// rgb × specular colour.
    pub specular_color_texture: Option<TextureUse>,
    /// r × transmission.
    pub transmission_texture: Option<TextureUse>,
}

impl Default for TexturedMaterial {
    fn default() -> Self {
        Self {
            name: String::new(),
            base: Material::default(),
            alpha: 1.0,
            alpha_mode: AlphaMode::Opaque,
            emission: Vec3::ZERO,
            double_sided: false,
            unlit: false,
            normal_scale: 1.0,
            sigma_a: Vec3::ZERO,
            priority: 0.0,
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            emissive_texture: None,
            specular_texture: None,
            specular_color_texture: None,
            transmission_texture: None,
        }
    }
}

impl TexturedMaterial {
    /// Lambertian with albedo `albedo`: no specular lobe at all.
    pub fn lambert(name: &str, albedo: Vec3) -> Self {
        let base = Material { base_color: albedo, metallic: 0.0, specular: 0.0, ..Material::default() };
        Self { name: name.to_owned(), base, ..Self::default() }
    }

    /// Black surface of radiance `radiance`.
    pub fn emitter(name: &str, radiance: Vec3) -> Self {
        Self { emission: radiance, ..Self::lambert(name, Vec3::ZERO) }
    }

    /// Whether surfaces of it are lights: they emit, and are not shadeless.
    pub(crate) fn is_light(&self) -> bool {
        !self.unlit && self.emission != Vec3::ZERO
    }

    /// Whether surfaces of it bound a volume that light travels through.
    pub(crate) fn is_volume(&self) -> bool {
        self.transmits() && !self.base.thin
    }

    /// Name of a factor that is not a finite number ≥ 0, if any.
    pub(crate) fn bad_factor(&self) -> Option<&'static str> {
        let b = &self.base;
        let mirror = b.mirror.map_or(Vec3::ZERO, |m| m.kr.max(Vec3::splat(m.blur)));
        [
            ("base colour", b.base_color.extend(self.alpha)),
            ("metallic, roughness or index of refraction", Vec4::new(b.metallic, b.roughness, b.ior, 0.0)),
            ("specular", b.specular_color.extend(b.specular)),
            ("transmission", Vec4::splat(b.transmission)),
            ("emission", self.emission.extend(0.0)),
            ("attenuation", self.sigma_a.extend(0.0)),
            ("mirror", mirror.extend(0.0)),
            ("normal scale", Vec4::splat(self.normal_scale.abs())),
        ]
        .into_iter()
        .find(|(_, v)| !(v.is_finite() && v.min_element() >= 0.0))
        .map(|(name, _)| name)
        .or_else(|| (!self.priority.is_finite()).then_some("priority"))
    }
}
