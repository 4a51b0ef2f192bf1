//! Materials with textures.
//!
//! Each parameter is the product of its factor and its texture; the base colour is also multiplied by the vertex colour
//! COLOR_0.
use dapple_materials::Material;
use glam::{Affine2, Vec2, Vec3, Vec4};

/// Interpretation of the alpha of the base colour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored: the surface is opaque.
    #[default]
    Opaque,
    /// The surface is opaque where alpha ≥ cutoff, and absent elsewhere.
    Mask {
        /// Smallest alpha at which the surface is opaque.
        cutoff: f32,
    },
    /// The surface covers the fraction alpha of the background.
    Blend,
}

/// A reference to a texture, with its uv set and KHR_texture_transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Index into the scene's textures.
    pub texture: u32,
    /// Index of the uv set: 0 (TEXCOORD_0) or 1 (TEXCOORD_1).
    pub uv_set: u32,
    /// Transform applied to uv before the lookup; None is the identity.
    pub transform: Option<Affine2>,
}

impl TextureUse {
    /// A reference by the first uv set without a transform.
    pub fn new(texture: u32) -> Self {
        Self { texture, uv_set: 0, transform: None }
    }

    /// Applies the transform to uv.
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        self.transform.map_or(uv, |t| t.matrix2 * uv + t.translation)
    }
}

/// A material with factors and textures: all supported properties of a glTF material.
#[derive(Clone, Debug)]
pub struct TexturedMaterial {
    /// Name for reports and AOVs.
    pub name: String,
    /// Factors of the scattering parameters.
    pub base: Material,
    /// Alpha factor of the base colour.
    pub alpha: f32,
    /// Interpretation of alpha.
    pub alpha_mode: AlphaMode,
    /// Radiance factor: emissiveFactor × strength (W·m⁻²·sr⁻¹).
    pub emission: Vec3,
    /// Whether it emits from both sides and is exempt from back-face culling.
    pub double_sided: bool,
    /// Whether it is unlit (shadeless): it emits its base colour as radiance from both sides and scatters nothing. It
    /// is visible to the camera, directly and through mirrors and clear glass, but does not illuminate other surfaces.
    pub unlit: bool,
    /// Scale of the x and y of the normal map.
    pub normal_scale: f32,
    /// Absorption coefficient of the interior: per world unit in the builder, per render unit in the scene; zero is
    /// clear.
    pub sigma_a: Vec3,
    /// Priority, any finite number: where volumes overlap, the one with the highest priority fills the overlap (see
    /// [`crate::Bodies`]).
    pub priority: f64,
    /// Texture whose rgb multiplies the base colour and whose a multiplies alpha.
    pub base_color_texture: Option<TextureUse>,
    /// Texture whose g multiplies roughness and whose b multiplies metallic.
    pub metallic_roughness_texture: Option<TextureUse>,
    /// Tangent-space normal map, +y up.
    pub normal_texture: Option<TextureUse>,
    /// Texture whose rgb multiplies the emission.
    pub emissive_texture: Option<TextureUse>,
    /// Texture whose a multiplies specular.
    pub specular_texture: Option<TextureUse>,
    /// Texture whose rgb multiplies the specular colour.
    pub specular_color_texture: Option<TextureUse>,
    /// Texture whose r multiplies transmission.
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
    /// Whether the surface is a perfect or blurred mirror, see [`Material::is_mirror`].
    pub fn is_mirror(&self) -> bool {
        self.base.is_mirror()
    }

    /// A Lambertian material with albedo `albedo`, without a specular lobe.
    pub fn lambert(name: &str, albedo: Vec3) -> Self {
        let base = Material { base_color: albedo, metallic: 0.0, specular: 0.0, ..Material::default() };
        Self { name: name.to_owned(), base, ..Self::default() }
    }

    /// A black material that emits radiance `radiance`.
    pub fn emitter(name: &str, radiance: Vec3) -> Self {
        Self { emission: radiance, ..Self::lambert(name, Vec3::ZERO) }
    }

    /// Whether its surfaces are lights: they emit and are not unlit.
    pub(crate) fn is_light(&self) -> bool {
        !self.unlit && self.emission != Vec3::ZERO
    }

    /// Whether its surfaces bound a volume that light passes through.
    pub(crate) fn is_volume(&self) -> bool {
        self.transmits() && !self.base.thin
    }

    /// Name of a factor that is not finite or is negative, if there is one.
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
