//! Bounds of the lobes of materials, including the effect of textures.
use crate::{Scene, TexturedMaterial};
use dapple_materials::{Lobes, Varying};

impl TexturedMaterial {
    /// All lobes that its surfaces can have anywhere.
    pub fn lobe_bounds(&self) -> Lobes {
        self.bounds(Varying { ior: true, ..self.varying() })
    }

    /// Lobes that its surfaces can have where textures do not change metallic and roughness, hit from outside of all
    /// bodies.
    pub fn lobes_by_factors(&self) -> Lobes {
        self.bounds(Varying { metallic_roughness: false, ..self.varying() })
    }

    /// Whether its surfaces transmit light anywhere.
    #[inline]
    pub fn transmits(&self) -> bool {
        !self.unlit && self.base.transmits(self.varying())
    }

    /// Whether its surfaces are infinitely thin walls.
    #[inline]
    pub fn is_thin(&self) -> bool {
        self.base.is_thin()
    }

    /// Whether light passes straight through its smooth surfaces, hit from outside of all bodies.
    pub fn keeps_direction(&self) -> bool {
        self.base.keeps_direction()
    }

    /// Whether its surfaces, by its factors, are smoother than this perceptual roughness.
    pub fn is_smoother_than(&self, roughness: f32) -> bool {
        self.base.is_smoother_than(roughness)
    }

    fn bounds(&self, varying: Varying) -> Lobes {
        if self.unlit { Lobes::NONE } else { self.base.lobe_bounds(varying) }
    }

    /// The parameters that vary because of textures.
    #[inline]
    fn varying(&self) -> Varying {
        Varying {
            metallic_roughness: self.metallic_roughness_texture.is_some(),
            transmission: self.transmission_texture.is_some(),
            ior: false,
        }
    }
}

impl Scene {
    /// The materials used by objects, without duplicates.
    pub fn used_materials(&self) -> impl Iterator<Item = &TexturedMaterial> {
        let mut seen = vec![false; self.materials.len()];
        self.objects.iter().for_each(|object| seen[object.material as usize] = true);
        self.materials.iter().zip(seen).filter(|(_, seen)| *seen).map(|(material, _)| material)
    }

    /// Bounds of the lobes of each used material.
    pub fn lobe_bounds(&self) -> Vec<Lobes> {
        self.used_materials().map(TexturedMaterial::lobe_bounds).collect()
    }
}
