//! What the layers and the statistics of an image need of the scene, the camera and the settings.

use crate::aov::Aov;
use crate::bias_report;
use crate::clear;
use crate::job::Job;
use dapple_scene::{Scene, Space};
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Facts about a render with which its sums can be composed to layers without the scene.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Facts {
    /// Size of the full image, in pixels.
    pub size: (u32, u32),
    /// Requested layers.
    pub aovs: Vec<Aov>,
    /// Whether the image itself is rendered.
    pub picture: bool,
    /// Whether the image has alpha.
    pub transparent: bool,
    /// Names of objects and materials; empty unless a layer shows them.
    pub names: Names,
    /// Origin of render space in world units, and render units per world unit.
    pub space: (DVec3, f64),
    /// Position of the camera and its backward axis, in render space.
    pub camera: (Vec3, Vec3),
    /// [`bias_report::BiasReport::lights_culled`].
    pub lights_culled: u64,
    /// [`bias_report::BiasReport::lights_unreachable`].
    pub lights_unreachable: u64,
}

impl Facts {
    pub fn of(job: &Job<'_>) -> Self {
        let settings = job.settings;
        let shows = |aov: &Aov| matches!(aov, Aov::ObjectId | Aov::MaterialId | Aov::Cryptomatte);
        let Space { centre, scale } = job.scene.space;
        Self {
            size: settings.size,
            aovs: settings.aovs.clone(),
            picture: settings.picture,
            transparent: settings.transparent,
            names: if settings.aovs.iter().any(shows) { Names::of(job.scene) } else { Names::default() },
            space: (centre, scale),
            camera: (job.camera.origin, job.camera.backward),
            lights_culled: bias_report::culled(job.scene),
            lights_unreachable: clear::unreachable(job.scene, job.sharp),
        }
    }

    /// World space and render space.
    pub fn space(&self) -> Space {
        Space { centre: self.space.0, scale: self.space.1 }
    }
}

/// Names of the objects and materials of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Names {
    /// The different names of objects; many objects may share one.
    objects: Vec<Arc<str>>,
    /// Names of the materials.
    materials: Vec<Arc<str>>,
    /// For each object, the indices of its name and of its material.
    of_object: Vec<(u32, u32)>,
}

impl Names {
    fn of(scene: &Scene) -> Self {
        let (mut objects, mut known) = (Vec::new(), HashMap::new());
        let mut index = |name: &Arc<str>| {
            *known.entry(Arc::as_ptr(name)).or_insert_with(|| {
                objects.push(name.clone());
                objects.len() as u32 - 1
            })
        };
        let of_object = scene.objects.iter().map(|object| (index(&object.name), object.material)).collect();
        let materials = scene.materials.iter().map(|material| material.name.as_str().into()).collect();
        Self { objects, materials, of_object }
    }

    /// Number of objects.
    pub fn count(&self) -> usize {
        self.of_object.len()
    }

    /// Name of an object; empty if there is no such object, as in a damaged file.
    pub fn object(&self, object: usize) -> &str {
        let name = self.of_object.get(object).and_then(|(name, _)| self.objects.get(*name as usize));
        name.map_or("", |name| name)
    }

    /// Index of the material of an object.
    pub fn material_of(&self, object: usize) -> u32 {
        self.of_object.get(object).map_or(0, |(_, material)| *material)
    }

    /// Name of a material; empty if there is no such material.
    pub fn material(&self, material: usize) -> &str {
        self.materials.get(material).map_or("", |name| name)
    }
}
