//! The textures that a material may have: one table. What decodes, checks, folds and looks up textures goes over it.
//!
//! A new texture is a field of [`TexturedMaterial`], a row here, and where files have it an arm in `gltf/material.rs`.
use crate::{AlphaMode, Reads, TextureUse, TexturedMaterial};
use dapple_imaging::texture::Channels;
use dapple_imaging::texture::Encoding::{self, Linear, Srgb};
use dapple_materials::Material;
use glam::{Vec3, Vec4};

/// Which texture of a material.
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

/// A texture that a material may have.
#[cfg_attr(not(feature = "gltf"), allow(dead_code, reason = "some columns are for files alone"))]
pub(crate) struct Slot {
    pub name: Name,
    /// How messages call it.
    pub label: &'static str,
    pub of: fn(&TexturedMaterial) -> &Option<TextureUse>,
    pub of_mut: fn(&mut TexturedMaterial) -> &mut Option<TextureUse>,
    /// What its numbers mean.
    pub encoding: Encoding,
    /// The channels that are looked at.
    pub channels: fn(&TexturedMaterial, &Reads) -> Channels,
    /// Whether anything of it shows: else files need not be read for it.
    pub shows: fn(&TexturedMaterial, &Reads) -> bool,
    /// It is a factor of reflection or transmission.
    pub scatters: bool,
    /// Multiplies the factors by a texel.
    pub multiply: fn(&mut Factors, Vec4),
    /// One of a single colour does no more than its factor.
    pub folds: bool,
}

/// What texels multiply.
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
        // Of one colour too it tilts the normal.
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
    /// Every texture the material looks up.
    pub fn textures(&self) -> impl Iterator<Item = &TextureUse> {
        SLOTS.iter().filter_map(move |slot| (slot.of)(self).as_ref())
    }

    /// The textures that are looked up, and the channels that then count.
    pub(crate) fn looked_at(&self, reads: &Reads) -> impl Iterator<Item = (u32, Channels)> {
        SLOTS.iter().filter_map(move |slot| {
            let channels = (slot.channels)(self, reads);
            Some(((slot.of)(self).as_ref()?.texture, channels))
        })
    }

    /// Gives the textures other indices.
    pub(crate) fn renumber(&mut self, index: impl Fn(u32) -> u32) {
        for slot in &SLOTS {
            if let Some(t) = (slot.of_mut)(self) {
                t.texture = index(t.texture);
            }
        }
    }

    /// Multiplies the factor of a texture of one colour by it; the texture is gone.
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

    /// A material whose textures are numbered by their rows.
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

    /// A texel of four primes tells which channels went where.
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
