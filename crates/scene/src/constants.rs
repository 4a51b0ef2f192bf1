//! Textures of one colour become factors, and textures that no material asks for are let go.

use crate::{TextureUse, TexturedMaterial};
use dapple_imaging::Texture;
use glam::Vec4;

/// Folds constant textures into the factors of `materials` and drops what is then unused; returns how many were folded.
/// Normal maps stay: a constant one still tilts the normal.
pub(crate) fn fold(materials: &mut [TexturedMaterial], textures: &mut Vec<Texture>) -> usize {
    let constants: Vec<Option<Vec4>> = textures.iter().map(Texture::constant).collect();
    materials.iter_mut().for_each(|m| fold_one(m, &constants));
    let mut used = vec![false; textures.len()];
    materials.iter().flat_map(|m| m.textures()).for_each(|t| used[t.texture as usize] = true);
    let folded = constants.iter().zip(&used).filter(|(c, used)| c.is_some() && !**used).count();
    let places: Vec<u32> = used
        .iter()
        .scan(0, |next, &used| {
            let here = *next;
            *next += u32::from(used);
            Some(here)
        })
        .collect();
    materials.iter_mut().flat_map(|m| m.textures_mut()).for_each(|t| t.texture = places[t.texture as usize]);
    let mut kept = used.iter();
    textures.retain(|_| kept.next().copied().unwrap_or(true));
    folded
}

fn fold_one(m: &mut TexturedMaterial, constants: &[Option<Vec4>]) {
    let take = |slot: &mut Option<TextureUse>| {
        let texel = constants[slot.as_ref()?.texture as usize]?;
        *slot = None;
        Some(texel)
    };
    if let Some(t) = take(&mut m.base_color_texture) {
        m.base.base_color *= t.truncate();
        m.alpha *= t.w;
    }
    if let Some(t) = take(&mut m.metallic_roughness_texture) {
        m.base.roughness *= t.y;
        m.base.metallic *= t.z;
    }
    if let Some(t) = take(&mut m.emissive_texture) {
        m.emission *= t.truncate();
    }
    if let Some(t) = take(&mut m.specular_texture) {
        m.base.specular *= t.w;
    }
    if let Some(t) = take(&mut m.specular_color_texture) {
        m.base.specular_color *= t.truncate();
    }
    if let Some(t) = take(&mut m.transmission_texture) {
        m.base.transmission *= t.x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_imaging::{Sampler, read::Rgba8, texture::Encoding};
    use glam::Vec3;

    fn texture(texels: Vec<[u8; 4]>) -> Texture {
        Texture::new(Rgba8 { width: texels.len(), height: 1, texels }, Encoding::Linear, Sampler::default())
    }

    #[test]
    fn constants_fold_and_the_rest_moves_up() {
        let mut textures = vec![texture(vec![[51, 102, 255, 255]; 4]), texture(vec![[0; 4], [255; 4]])];
        let mut materials = vec![TexturedMaterial {
            base_color_texture: Some(TextureUse::new(0)),
            emissive_texture: Some(TextureUse::new(1)),
            normal_texture: Some(TextureUse::new(1)),
            ..TexturedMaterial::default()
        }];
        assert_eq!(fold(&mut materials, &mut textures), 1);
        assert_eq!(materials[0].base.base_color, Vec3::new(0.2, 0.4, 1.0));
        assert!(materials[0].base_color_texture.is_none());
        assert_eq!(materials[0].emissive_texture.unwrap().texture, 0);
        assert_eq!(textures.len(), 1);
    }

    #[test]
    fn a_constant_normal_map_stays() {
        let mut textures = vec![texture(vec![[200, 128, 200, 255]])];
        let mut materials = vec![TexturedMaterial {
            normal_texture: Some(TextureUse::new(0)),
            ..TexturedMaterial::default()
        }];
        assert_eq!(fold(&mut materials, &mut textures), 0);
        assert!(materials[0].normal_texture.is_some() && textures.len() == 1);
    }
}
