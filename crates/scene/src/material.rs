//! Materials with textures, and their values at a hit.
//!
//! A value is its factor times its texture; a base colour is multiplied by the vertex colour COLOR_0 as well.
use crate::Reads;
use dapple_geometry::{Hit, World};
use dapple_imaging::{Texture, texture::Channels};
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

    #[inline(never)]
    fn lookup(&self, world: &World, textures: &[Texture], hit: &Hit) -> Vec4 {
        textures[self.texture as usize].lookup(self.apply(world.uv(hit, self.uv_set as usize)))
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

    /// Every texture the material looks up.
    pub fn textures(&self) -> impl Iterator<Item = &TextureUse> {
        [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.normal_texture,
            &self.emissive_texture,
            &self.specular_texture,
            &self.specular_color_texture,
            &self.transmission_texture,
        ]
        .into_iter()
        .flatten()
    }

    /// The textures that are looked up, and the channels that then count.
    pub(crate) fn looked_at(&self, reads: &Reads) -> impl Iterator<Item = (u32, Channels)> {
        let color = if reads.color(self) { Channels::RGB } else { Channels::NONE };
        let alpha = if self.alpha_mode == AlphaMode::Opaque { Channels::NONE } else { Channels::A };
        [
            (&self.base_color_texture, color.or(alpha)),
            (&self.metallic_roughness_texture, Channels::GB),
            (&self.normal_texture, Channels::RGB),
            (&self.emissive_texture, Channels::RGB),
            (&self.specular_texture, Channels::A),
            (&self.specular_color_texture, Channels::RGB),
            (&self.transmission_texture, Channels::R),
        ]
        .into_iter()
        .filter_map(|(of, channels)| Some((of.as_ref()?.texture, channels)))
    }

    pub(crate) fn textures_mut(&mut self) -> impl Iterator<Item = &mut TextureUse> {
        [
            &mut self.base_color_texture,
            &mut self.metallic_roughness_texture,
            &mut self.normal_texture,
            &mut self.emissive_texture,
            &mut self.specular_texture,
            &mut self.specular_color_texture,
            &mut self.transmission_texture,
        ]
        .into_iter()
        .flatten()
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

    /// Factors times vertex colours at a hit.
    #[inline]
    pub(crate) fn untextured(&self, world: &World, hit: &Hit) -> Material {
        Material { base_color: self.base.base_color * world.color(hit).truncate(), ..self.base }
    }

    /// Factors times vertex colours and textures at a hit.
    pub(crate) fn at(&self, world: &World, textures: &[Texture], hit: &Hit) -> Material {
        let mut m = self.untextured(world, hit);
        let texel = |of: &TextureUse| of.lookup(world, textures, hit);
        if let Some(t) = used(&self.base_color_texture) {
            m.base_color *= texel(t).truncate();
        }
        if let Some(t) = used(&self.metallic_roughness_texture) {
            let value = texel(t);
            m.roughness *= value.y;
            m.metallic *= value.z;
        }
        if let Some(t) = used(&self.specular_texture) {
            m.specular *= texel(t).w;
        }
        if let Some(t) = used(&self.specular_color_texture) {
            m.specular_color *= texel(t).truncate();
        }
        if let Some(t) = used(&self.transmission_texture) {
            m.transmission *= texel(t).x;
        }
        m
    }

    /// Base colour and alpha: factor × texture × vertex colour.
    pub(crate) fn base_color(&self, world: &World, textures: &[Texture], hit: &Hit) -> Vec4 {
        let factor = self.base.base_color.extend(self.alpha) * world.color(hit);
        used(&self.base_color_texture).map_or(factor, |t| factor * t.lookup(world, textures, hit))
    }

    /// Fraction of the surface that is there, in [0, 1].
    pub(crate) fn opacity(&self, world: &World, textures: &[Texture], hit: &Hit) -> f32 {
        let alpha = || self.base_color(world, textures, hit).w;
        match self.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask { cutoff } => f32::from(alpha() >= cutoff),
            AlphaMode::Blend => alpha().clamp(0.0, 1.0),
        }
    }

    /// Radiance sent from an emitting side: factor × texture (unlit: the base colour).
    pub(crate) fn radiance(&self, world: &World, textures: &[Texture], hit: &Hit) -> Vec3 {
        if self.unlit {
            return self.base_color(world, textures, hit).truncate();
        }
        match used(&self.emissive_texture) {
            Some(t) if self.emission != Vec3::ZERO => {
                self.emission * t.lookup(world, textures, hit).truncate()
            }
            _ => self.emission,
        }
    }

    /// The tangent-space normal at a hit, unit, or None where there is no map or it says nothing usable.
    pub(crate) fn normal(&self, world: &World, textures: &[Texture], hit: &Hit) -> Option<Vec3> {
        let texel = used(&self.normal_texture)?.lookup(world, textures, hit).truncate();
        let n = (texel * 2.0 - 1.0) * Vec3::new(self.normal_scale, self.normal_scale, 1.0);
        n.try_normalize()
    }
}

#[inline]
fn used(texture: &Option<TextureUse>) -> Option<&TextureUse> {
    texture.as_ref().filter(|_| cfg!(not(without = "textures")))
}
