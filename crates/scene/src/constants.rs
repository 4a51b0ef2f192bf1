//! Folding of constant textures into material factors, and removal of unused textures.

use crate::TexturedMaterial;
use crate::slots::SLOTS;
use dapple_imaging::Texture;
use glam::Vec4;

/// Folds constant textures into the factors of `materials` and removes textures that are then unused; returns the
/// number folded. Normal maps are kept, as a constant one still tilts the normal.
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
    materials.iter_mut().for_each(|m| m.renumber(|t| places[t as usize]));
    let mut kept = used.iter();
    textures.retain(|_| kept.next().copied().unwrap_or(true));
    folded
}

fn fold_one(m: &mut TexturedMaterial, constants: &[Option<Vec4>]) {
    for slot in SLOTS.iter().filter(|slot| slot.folds) {
        let texel = (slot.of)(m).as_ref().and_then(|t| constants[t.texture as usize]);
        if let Some(texel) = texel {
            m.fold(slot, texel);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TextureUse;
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
