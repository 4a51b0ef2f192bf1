//! Which lobes can the materials of a scene have anywhere? Textures multiply factors, so the factors bound them.

use dapple_materials::Material;
use dapple_scene::{Scene, TexturedMaterial};
use glam::Vec3;

/// What an integral over a lobe has to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Width {
    /// No such lobe.
    Absent,
    /// One direction.
    Smooth,
    /// A spread of directions somewhere.
    Rough,
}

/// Lobes of one material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kinds {
    pub diffuse: bool,
    pub reflection: Width,
    pub transmission: Width,
}

impl Kinds {
    const NONE: Self = Self { diffuse: false, reflection: Width::Absent, transmission: Width::Absent };

    /// Of every material that an object uses.
    pub fn used(scene: &Scene) -> Vec<Self> {
        let mut seen = vec![false; scene.materials.len()];
        scene.objects.iter().for_each(|o| seen[o.material as usize] = true);
        scene.materials.iter().zip(seen).filter(|(_, seen)| *seen).map(|(m, _)| Self::of(m)).collect()
    }

    fn of(m: &TexturedMaterial) -> Self {
        let base: &Material = &m.base;
        if m.unlit {
            return Self::NONE;
        }
        let width = |there: bool, rough: bool| match (there, rough) {
            (false, _) => Width::Absent,
            (true, false) => Width::Smooth,
            (true, true) => Width::Rough,
        };
        if let Some(mirror) = base.mirror {
            return Self { reflection: width(mirror.kr != Vec3::ZERO, mirror.blur > 0.0), ..Self::NONE };
        }
        let metal = base.metallic == 1.0 && m.metallic_roughness_texture.is_none();
        let clear = base.transmission == 1.0 && m.transmission_texture.is_none();
        let rough = base.roughness > 0.0;
        Self {
            diffuse: !metal && !clear && base.base_color != Vec3::ZERO,
            reflection: width(base.metallic > 0.0 || base.specular > 0.0 || base.transmission > 0.0, rough),
            transmission: width(!metal && base.transmission > 0.0, rough),
        }
    }

    /// How many lobes.
    pub fn count(&self) -> usize {
        let reflections =
            [self.reflection, self.transmission].iter().filter(|w| **w != Width::Absent).count();
        usize::from(self.diffuse) + reflections
    }

    /// A spread of directions: light can be aimed at.
    pub fn spreads(&self) -> bool {
        self.diffuse || self.reflection == Width::Rough || self.transmission == Width::Rough
    }
}
