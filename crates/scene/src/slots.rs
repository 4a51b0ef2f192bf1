//! Table of the texture slots of a material, used to decode, check, fold and look up textures.
//!
//! A new texture needs a field of [`TexturedMaterial`], a row here and, if files contain it, an arm in
//! `gltf/material.rs`.
use crate::{AlphaMode, Reads, TextureUse, TexturedMaterial};
use dapple_imaging::texture::Channels;
use dapple_imaging::texture::Encoding::{self, Linear, Srgb};
use dapple_materials::Material;
use glam::{Vec3, Vec4};

/// Identifies a texture slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Name {
    BaseColor,
    MetallicRoughness,
    Normal,
    Emission,
    Specular,
    SpecularColor,
    Transmission,
}

/// A texture slot of a material.
#[cfg_attr(not(feature = "gltf"), allow(dead_code, reason = "some columns are used only by the glTF reader"))]
pub(crate) struct Slot {
    pub name: Name,
    /// Name in messages.
    pub label: &'static str,
    pub of: fn(&TexturedMaterial) -> &Option<TextureUse>,
    pub of_mut: fn(&mut TexturedMaterial) -> &mut Option<TextureUse>,
    /// Encoding of its texels.
    pub encoding: Encoding,
    /// The channels that are read.
    pub channels: fn(&TexturedMaterial, &Reads) -> Channels,
    /// Whether it affects the result; otherwise it need not be read.
    pub shows: fn(&TexturedMaterial, &Reads) -> bool,
    /// Whether it is a factor of reflection or transmission.
    pub scatters: bool,
    /// Multiplies the factors by a texel.
    pub multiply: fn(&mut Factors, Vec4),
    /// Whether a constant texture can be folded into the factors.
    pub folds: bool,
}

/// Material factors that texels multiply.
pub(crate) struct Factors {
    pub base: Material,
    pub alpha: f32,
    pub emission: Vec3,
}

pub(crate) const SLOTS: [Slot; 7] = [
    Slot {
        name: Name::BaseColor,
        label: "base colour",
        of: |m| &m.base_color_texture,
        of_mut: |m| &mut m.base_color_texture,
        encoding: Srgb,
        channels: |m, reads| {
            let color = if reads.color(m) { Channels::RGB } else { Channels::NONE };
            color.or(if m.alpha_mode == AlphaMode::Opaque { Channels::NONE } else { Channels::A })
        },
        shows: |m, reads| reads.base_color(m),
        scatters: true,
        multiply: |f, texel| {
            f.base.base_color *= texel.truncate();
            f.alpha *= texel.w;
        },
        folds: true,
    },
    Slot {
        name: Name::MetallicRoughness,
        label: "metallic-roughness",
        of: |m| &m.metallic_roughness_texture,
        of_mut: |m| &mut m.metallic_roughness_texture,
        encoding: Linear,
        channels: |_, _| Channels::GB,
        shows: |m, reads| reads.matter() && !m.unlit,
        scatters: true,
        multiply: |f, texel| {
            f.base.roughness *= texel.y;
            f.base.metallic *= texel.z;
        },
        folds: true,
    },
    Slot {
        name: Name::Normal,
        label: "normal",
        of: |m| &m.normal_texture,
        of_mut: |m| &mut m.normal_texture,
        encoding: Linear,
        channels: |_, _| Channels::RGB,
        shows: |m, reads| reads.shading_normals() && !m.unlit,
        scatters: false,
        multiply: |_, _| (),
        // A constant normal map still tilts the normal.
        folds: false,
    },
    Slot {
        name: Name::Emission,
        label: "emissive",
        of: |m| &m.emissive_texture,
        of_mut: |m| &mut m.emissive_texture,
        encoding: Srgb,
        channels: |_, _| Channels::RGB,
        shows: |m, reads| reads.light && m.emission != Vec3::ZERO,
        scatters: false,
        multiply: |f, texel| f.emission *= texel.truncate(),
        folds: true,
    },
    Slot {
        name: Name::Specular,
        label: "specular",
        of: |m| &m.specular_texture,
        of_mut: |m| &mut m.specular_texture,
        encoding: Linear,
        channels: |_, _| Channels::A,
        shows: |m, reads| reads.matter() && m.base.specular > 0.0,
        scatters: true,
        multiply: |f, texel| f.base.specular *= texel.w,
        folds: true,
    },
    Slot {
        name: Name::SpecularColor,
        label: "specular colour",
        of: |m| &m.specular_color_texture,
        of_mut: |m| &mut m.specular_color_texture,
        encoding: Srgb,
        channels: |_, _| Channels::RGB,
        shows: |m, reads| reads.matter() && m.base.specular > 0.0,
        scatters: true,
        multiply: |f, texel| f.base.specular_color *= texel.truncate(),
        folds: true,
    },
    Slot {
        name: Name::Transmission,
        label: "transmission",
        of: |m| &m.transmission_texture,
        of_mut: |m| &mut m.transmission_texture,
        encoding: Linear,
        channels: |_, _| Channels::R,
        shows: |m, reads| reads.matter() && m.base.transmission > 0.0,
        scatters: true,
        multiply: |f, texel| f.base.transmission *= texel.x,
        folds: true,
    },
];

impl TexturedMaterial {
    /// All textures of the material.
    pub fn textures(&self) -> impl Iterator<Item = &TextureUse> {
        SLOTS.iter().filter_map(move |slot| (slot.of)(self).as_ref())
    }

    /// Indices of the textures of the material, with the channels that are read.
    pub(crate) fn looked_at(&self, reads: &Reads) -> impl Iterator<Item = (u32, Channels)> {
        SLOTS.iter().filter_map(move |slot| {
            let channels = (slot.channels)(self, reads);
            Some(((slot.of)(self).as_ref()?.texture, channels))
        })
    }

    /// Replaces the indices of the textures.
    pub(crate) fn renumber(&mut self, index: impl Fn(u32) -> u32) {
        for slot in &SLOTS {
            if let Some(t) = (slot.of_mut)(self) {
                t.texture = index(t.texture);
            }
        }
    }

    /// Replaces a constant texture: multiplies the factors by its texel and removes it.
    pub(crate) fn fold(&mut self, slot: &Slot, texel: Vec4) {
        let mut factors = Factors { base: self.base, alpha: self.alpha, emission: self.emission };
        (slot.multiply)(&mut factors, texel);
        (self.base, self.alpha, self.emission) = (factors.base, factors.alpha, factors.emission);
        *(slot.of_mut)(self) = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A material whose texture indices equal their rows.
    fn full() -> TexturedMaterial {
        let mut material = TexturedMaterial::default();
        for (i, slot) in SLOTS.iter().enumerate() {
            *(slot.of_mut)(&mut material) = Some(TextureUse::new(i as u32));
        }
        material
    }

    #[test]
    fn every_row_has_a_texture_of_its_own() {
        let material = full();
        assert!(material.textures().map(|t| t.texture).eq(0..SLOTS.len() as u32));
        for (i, slot) in SLOTS.iter().enumerate() {
            assert_eq!((slot.of)(&material).unwrap().texture, i as u32, "{}", slot.label);
            assert_eq!(slot.name as usize, i, "{}", slot.label);
        }
    }

    #[test]
    fn renumbering_reaches_every_texture() {
        let mut material = full();
        material.renumber(|i| 10 - i);
        assert!(material.textures().map(|t| t.texture).eq((4..=10).rev()));
    }

    /// A texel of four primes shows which channel multiplies which factor.
    #[test]
    fn texels_multiply_their_own_factors() {
        let mut material = full();
        material.base.transmission = 1.0;
        material.emission = Vec3::ONE;
        for slot in SLOTS.iter().filter(|slot| slot.folds) {
            material.fold(slot, Vec4::new(2.0, 3.0, 5.0, 7.0));
        }
        let (rgb, b) = (Vec3::new(2.0, 3.0, 5.0), material.base);
        assert_eq!((b.base_color, material.alpha, material.emission), (rgb, 7.0, rgb));
        assert_eq!((b.roughness, b.metallic, b.specular, b.transmission), (3.0, 5.0, 7.0, 2.0));
        assert_eq!(b.specular_color, rgb);
        assert_eq!(material.textures().count(), 1, "the normal map stays");
    }
}
