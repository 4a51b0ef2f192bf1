//! Evaluation of a material at a hit: factors times textures and vertex colours.
use crate::slots::{Factors, SLOTS};
use crate::{AlphaMode, TextureUse, TexturedMaterial};
use dapple_geometry::{Accel, Hit};
use dapple_imaging::Texture;
use dapple_materials::Material;
use glam::{Vec3, Vec4};

impl TextureUse {
    #[inline(never)]
    fn lookup(&self, accel: &Accel, textures: &[Texture], hit: &Hit) -> Vec4 {
        textures[self.texture as usize].lookup(self.apply(accel.uv(hit, self.uv_set as usize)))
    }
}

impl TexturedMaterial {
    /// Factors times vertex colours at a hit.
    #[inline]
    pub(crate) fn untextured(&self, accel: &Accel, hit: &Hit) -> Material {
        Material { base_color: self.base.base_color * accel.color(hit).truncate(), ..self.base }
    }

    /// Factors times vertex colours and textures at a hit.
    pub(crate) fn at(&self, accel: &Accel, textures: &[Texture], hit: &Hit) -> Material {
        let base = self.untextured(accel, hit);
        let mut factors = Factors { base, alpha: self.alpha, emission: self.emission };
        // Unrolled: a loop would make indirect calls through the table at every hit.
        const { assert!(SLOTS.len() == 7, "one line for each row") };
        let place = (accel, textures, hit);
        self.scale::<0>(&mut factors, place);
        self.scale::<1>(&mut factors, place);
        self.scale::<2>(&mut factors, place);
        self.scale::<3>(&mut factors, place);
        self.scale::<4>(&mut factors, place);
        self.scale::<5>(&mut factors, place);
        self.scale::<6>(&mut factors, place);
        factors.base
    }

    /// Multiplies the factors by the texture of a row if it affects reflection or transmission.
    #[inline(always)]
    fn scale<const ROW: usize>(
        &self,
        factors: &mut Factors,
        (accel, textures, hit): (&Accel, &[Texture], &Hit),
    ) {
        let slot = const { &SLOTS[ROW] };
        if let (true, Some(t)) = (slot.scatters, used((slot.of)(self))) {
            (slot.multiply)(factors, t.lookup(accel, textures, hit));
        }
    }

    /// Base colour and alpha: factor × texture × vertex colour.
    pub(crate) fn base_color(&self, accel: &Accel, textures: &[Texture], hit: &Hit) -> Vec4 {
        let factor = self.base.base_color.extend(self.alpha) * accel.color(hit);
        used(&self.base_color_texture).map_or(factor, |t| factor * t.lookup(accel, textures, hit))
    }

    /// Opacity of the surface, in [0, 1].
    pub(crate) fn opacity(&self, accel: &Accel, textures: &[Texture], hit: &Hit) -> f32 {
        let alpha = || self.base_color(accel, textures, hit).w;
        match self.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask { cutoff } => f32::from(alpha() >= cutoff),
            AlphaMode::Blend => alpha().clamp(0.0, 1.0),
        }
    }

    /// Radiance emitted from an emitting side: factor × texture (unlit: the base colour).
    pub(crate) fn radiance(&self, accel: &Accel, textures: &[Texture], hit: &Hit) -> Vec3 {
        if self.unlit {
            return self.base_color(accel, textures, hit).truncate();
        }
        match used(&self.emissive_texture) {
            Some(t) if self.emission != Vec3::ZERO => {
                self.emission * t.lookup(accel, textures, hit).truncate()
            }
            _ => self.emission,
        }
    }

    /// The unit tangent-space normal at a hit; None if there is no normal map or its texel is degenerate.
    pub(crate) fn normal(&self, accel: &Accel, textures: &[Texture], hit: &Hit) -> Option<Vec3> {
        let texel = used(&self.normal_texture)?.lookup(accel, textures, hit).truncate();
        let n = (texel * 2.0 - 1.0) * Vec3::new(self.normal_scale, self.normal_scale, 1.0);
        n.try_normalize()
    }
}

#[inline]
fn used(texture: &Option<TextureUse>) -> Option<&TextureUse> {
    texture.as_ref().filter(|_| cfg!(not(without = "textures")))
}
