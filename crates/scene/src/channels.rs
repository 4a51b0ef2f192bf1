//! Removal of texture channels that no material reads.

use crate::{Reads, TexturedMaterial};
use dapple_imaging::{Texture, texture::Channels};

/// The union of the channels that materials read, for each of `count` textures.
pub(crate) fn looked_at(materials: &[TexturedMaterial], count: usize, reads: &Reads) -> Vec<Channels> {
    let mut all = vec![Channels::NONE; count];
    for (texture, channels) in materials.iter().flat_map(|m| m.looked_at(reads)) {
        let of = &mut all[texture as usize];
        *of = of.or(channels);
    }
    all
}

/// Removes the channels that are not read.
pub(crate) fn drop_others(materials: &[TexturedMaterial], textures: &mut Vec<Texture>, reads: &Reads) {
    if reads.everything {
        return;
    }
    let wanted = looked_at(materials, textures.len(), reads);
    let kept = std::mem::take(textures).into_iter().zip(wanted).map(|(t, channels)| t.keep(channels));
    *textures = kept.collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AlphaMode, TextureUse};
    use dapple_imaging::{Sampler, read::Rgba8, texture::Encoding};

    /// Number of channels kept of a texture whose channels all differ.
    fn kept(change: impl FnOnce(&mut TexturedMaterial), reads: Reads) -> usize {
        let image = Rgba8 { width: 2, height: 1, texels: vec![[1, 2, 3, 4], [5, 6, 7, 9]] };
        let mut textures = vec![Texture::new(image, Encoding::Linear, Sampler::default())];
        let mut material = TexturedMaterial::default();
        change(&mut material);
        drop_others(&[material], &mut textures, &reads);
        textures[0].channels()
    }

    #[test]
    fn only_what_a_slot_reads_is_kept() {
        let all = Reads::default();
        let texture = Some(TextureUse::new(0));
        assert_eq!(kept(|m| m.base_color_texture = texture, all), 3);
        assert_eq!(kept(|m| m.metallic_roughness_texture = texture, all), 2);
        assert_eq!(kept(|m| m.normal_texture = texture, all), 3);
        assert_eq!(kept(|m| m.specular_texture = texture, all), 1);
        assert_eq!(kept(|m| m.transmission_texture = texture, all), 1);
        assert_eq!(kept(|_| (), all), 0);
        let both = |m: &mut TexturedMaterial| {
            (m.transmission_texture, m.metallic_roughness_texture) = (texture, texture);
        };
        assert_eq!(kept(both, all), 3);
        assert_eq!(kept(both, Reads::EVERYTHING), 4);
    }

    #[test]
    fn holes_take_alpha_and_alone_nothing_else() {
        let holes = |m: &mut TexturedMaterial| {
            m.alpha_mode = AlphaMode::Blend;
            m.base_color_texture = Some(TextureUse::new(0));
        };
        assert_eq!(kept(holes, Reads::default()), 4);
        let unseen = Reads { scattering: false, albedo: false, normals: false, ..Reads::default() };
        assert_eq!(kept(holes, unseen), 1);
    }
}
