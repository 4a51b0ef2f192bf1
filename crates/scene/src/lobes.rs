//! Which lobes can the materials of a scene have, where textures multiply their factors?
use crate::{Scene, TexturedMaterial};
use dapple_materials::{Lobes, Varying};

impl TexturedMaterial {
    /// Lobes that surfaces of it can have, anywhere.
    pub fn lobe_bounds(&self) -> Lobes {
        self.bounds(Varying { ior: true, ..self.varying() })
    }

    /// Lobes that surfaces of it can have where textures leave metal and roughness as the factors are, met from outside of
    /// all bodies.
    pub fn lobes_by_factors(&self) -> Lobes {
        self.bounds(Varying { metallic_roughness: false, ..self.varying() })
    }

    /// Whether light goes through surfaces of it, somewhere at least.
    #[inline]
    pub fn transmits(&self) -> bool {
        !self.unlit && self.base.transmits(self.varying())
    }

    /// Whether it is the surface of an infinitely thin wall.
    #[inline]
    pub fn is_thin(&self) -> bool {
        self.base.is_thin()
    }

    /// Whether light that goes through smooth surfaces of it goes straight on, met from outside of all bodies.
    pub fn keeps_direction(&self) -> bool {
        self.base.keeps_direction()
    }

    /// Whether by their factors surfaces of it are smoother than ones of this perceptual roughness.
    pub fn is_smoother_than(&self, roughness: f32) -> bool {
        self.base.is_smoother_than(roughness)
    }

    fn bounds(&self, varying: Varying) -> Lobes {
        if self.unlit { Lobes::NONE } else { self.base.lobe_bounds(varying) }
    }

    /// What textures change from place to place.
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
    /// The materials that objects have, each once.
    pub fn used_materials(&self) -> impl Iterator<Item = &TexturedMaterial> {
        let mut seen = vec![false; self.materials.len()];
        self.objects.iter().for_each(|object| seen[object.material as usize] = true);
        self.materials.iter().zip(seen).filter(|(_, seen)| *seen).map(|(material, _)| material)
    }

    /// Lobes that each of the materials can have that objects have.
    pub fn lobe_bounds(&self) -> Vec<Lobes> {
        self.used_materials().map(TexturedMaterial::lobe_bounds).collect()
    }
}
