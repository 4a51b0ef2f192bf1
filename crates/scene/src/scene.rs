//! The validated scene: everything that a ray tracer reads, in render space (see [`crate::space`]).
use crate::mapped_frame::MappedNormal;
use crate::{
    AlphaMode, Bodies, Object, SharedPlaces, Space, Survey, TexturedMaterial, Warning, emission::AreaLights,
    emitter::Emitter,
};
use dapple_camera::{Camera, Shutter};
use dapple_geometry::{Accel, Hit, Surface};
use dapple_imaging::Texture;
use dapple_lights::{Environment, Light, LightPoint, LightSampler};
use dapple_materials::Material;
use dapple_math::Frame;
use glam::{DVec3, Vec2, Vec3};
use std::{path::PathBuf, sync::Arc};

/// A camera and its name.
#[derive(Clone, Debug)]
pub struct NamedCamera {
    /// Name from the file, not necessarily unique.
    pub name: Arc<str>,
    /// The camera in render space.
    pub camera: Camera,
    /// Aspect ratio (width / height) given by the file.
    pub aspect: Option<f32>,
}

/// Geometry, materials, lights and cameras of one scene, validated: every index is in range, and every number is
/// finite. Created by [`crate::SceneBuilder::build`].
#[derive(Debug)]
pub struct Scene {
    /// Name of the scene: the stem of the file's name.
    pub name: String,
    /// Map between world space and render space.
    pub space: Space,
    /// Acceleration structure with the geometry.
    pub accel: Accel,
    /// Data of the objects, by their index in `accel`.
    pub objects: Vec<Object>,
    /// Volumes that light passes through, in order of decreasing precedence where they overlap.
    pub bodies: Bodies,
    /// Materials by index.
    pub materials: Vec<TexturedMaterial>,
    /// Textures by index.
    pub textures: Vec<Texture>,
    /// All lights: area lights in the order of their surfaces, then punctual lights, then the environment.
    pub lights: Vec<Light>,
    /// Sampler that selects a light; None if there is none that can be sampled.
    pub light_choice: Option<LightSampler>,
    /// Index of the environment in `lights`.
    pub environment: Option<u32>,
    /// Cameras; at least one.
    pub cameras: Vec<NamedCamera>,
    /// Time of the animation in seconds to which the shutter is relative.
    pub at: f64,
    /// Whether the scene depends on `at`: a visible node is animated.
    pub is_animated: bool,
    /// Opening and closing time of the shutter. Times of rays are in seconds from its opening.
    pub shutter: Shutter,
    /// Statistics and features of the scene.
    pub survey: Survey,
    /// Unit in which the intensities of a file's punctual lights were interpreted; None without such lights.
    pub light_unit: Option<crate::light_unit::TakenUnit>,
    /// Differences between the file and what is rendered.
    pub warnings: Vec<Warning>,
    /// The file from which the scene was read and the files that it names, used or not; empty for a scene built in
    /// code.
    pub files: Vec<PathBuf>,
    /// Lower and upper corner of the world-space bounding box of all objects when the shutter opens; None without
    /// objects.
    pub bounds: Option<(DVec3, DVec3)>,
    /// Half the diagonal of the scene's bounding box, in render space.
    pub(crate) radius: f32,
    /// Coincident surfaces and lights; None if there are none.
    pub shared_places: Option<SharedPlaces>,
    pub(crate) area: AreaLights,
}

/// Shading data of a hit, with its textures looked up.
#[derive(Clone, Copy, Debug)]
pub struct Shading {
    /// Shading frame; z is the shading normal (normal map applied) on the *front* side of the surface: z·ng > 0.
    pub frame: Frame,
    /// Material parameters: factors times textures.
    pub material: Material,
    /// Whether the material is unlit (shadeless): it emits its base colour and scatters nothing.
    pub unlit: bool,
}

impl Scene {
    /// Adds an environment unless the scene has one already.
    pub fn surround(&mut self, environment: Environment) {
        if self.environment.is_some() {
            return;
        }
        self.environment = Some(self.lights.len() as u32);
        self.lights.push(Light::Environment(environment));
        self.light_choice = LightSampler::new(&self.lights, self.radius);
        self.survey.lights = self.lights.len();
    }

    /// The material of an object.
    pub fn material(&self, object: u32) -> &TexturedMaterial {
        &self.materials[self.objects[object as usize].material as usize]
    }

    /// The material of an object, and whether it looks up textures.
    #[inline]
    pub(crate) fn material_of(&self, object: u32) -> (&TexturedMaterial, bool) {
        let object = &self.objects[object as usize];
        let textured = cfg!(not(without = "textures")) && object.textured;
        (&self.materials[object.material as usize], textured)
    }

    /// Material and shading frame at a hit at a time in seconds from the opening of the shutter.
    pub fn shading(&self, hit: &Hit, surface: &Surface, time: f32) -> Shading {
        let (material, textured) = self.material_of(hit.object);
        if textured {
            return self.textured_shading(material, hit, surface, time);
        }
        Shading {
            frame: Frame::from_z(surface.ns),
            material: material.untextured(&self.accel, hit),
            unlit: material.unlit,
        }
    }

    #[inline(never)]
    fn textured_shading(
        &self,
        material: &TexturedMaterial,
        hit: &Hit,
        surface: &Surface,
        time: f32,
    ) -> Shading {
        Shading {
            frame: self.frame(material, hit, surface, time),
            material: material.at(&self.accel, &self.textures, hit),
            unlit: material.unlit,
        }
    }

    /// Frame about the shading normal; see [`MappedNormal::frame`].
    fn frame(&self, material: &TexturedMaterial, hit: &Hit, surface: &Surface, time: f32) -> Frame {
        if material.normal_texture.is_none() {
            return Frame::from_z(surface.ns);
        }
        let Some(tangent) = self.accel.tangent_at(hit, time) else { return Frame::from_z(surface.ns) };
        let normal = material.normal(&self.accel, &self.textures, hit);
        let mapped = MappedNormal::<f32> {
            tangent: tangent.truncate().into(),
            sign: tangent.w,
            normal: normal.unwrap_or(Vec3::Z).into(),
            is_sound: normal.is_some(),
        };
        mapped.frame(surface.ns.into(), surface.ng.into()).into()
    }

    /// Radiance (W·m⁻²·sr⁻¹) emitted at a hit towards the unit vector `wo`: from the front side, and from both if the
    /// material is double-sided or unlit.
    pub fn emission(&self, hit: &Hit, surface: &Surface, wo: Vec3) -> Vec3 {
        let (material, textured) = self.material_of(hit.object);
        if !(material.unlit || material.double_sided || wo.dot(surface.ng) > 0.0) {
            Vec3::ZERO
        } else if textured || material.unlit {
            material.radiance(&self.accel, &self.textures, hit)
        } else {
            material.emission
        }
    }

    /// The material of all of an object's surface, if it is the same everywhere and emits nothing.
    pub fn uniform_material(&self, object: u32) -> Option<&Material> {
        let (material, textured) = self.material_of(object);
        let is_dark = material.emission == Vec3::ZERO && !material.unlit;
        (is_dark && !textured && !self.accel.has_colors(object)).then_some(&material.base)
    }

    /// Whether the material of an object is looked up at every hit: it has textures or vertex colours.
    pub fn has_varying_material(&self, object: u32) -> bool {
        self.material_of(object).1 || self.accel.has_colors(object)
    }

    /// Object and first primitive of an area light's surface.
    pub fn source_of(&self, light: u32) -> Option<(u32, u32)> {
        self.area.sources.get(light as usize).copied()
    }

    /// The area light to which the hit surface belongs.
    pub fn light_of(&self, hit: &Hit) -> Option<u32> {
        self.area.of(hit)
    }

    /// Radiance that area light `light` emits from a sampled point at a time, including its texture and opacity. `mean`
    /// is the radiance of the sample, which is returned unchanged if the light is uniform.
    pub fn light_radiance(&self, light: u32, point: &LightPoint, mean: Vec3, time: f32) -> Vec3 {
        let Some(&(object, primitive)) = self.area.sources.get(light as usize) else { return mean };
        let emitter = self.emitter(object);
        if emitter.is_constant() {
            return mean;
        }
        let at = self.accel.coordinates_at(object, point.p, time).unwrap_or(Vec2::new(point.u, point.v));
        emitter.radiance(&Hit { t: 0.0, u: at.x, v: at.y, primitive, object })
    }

    /// Whether the radiance of a light varies over its surface, so that [`Scene::light_radiance`] is not that of the
    /// sample.
    pub fn is_patterned(&self, light: u32) -> bool {
        self.source_of(light).is_some_and(|(object, _)| !self.emitter(object).is_constant())
    }

    /// Opacity at a hit: 1 for opaque materials, 0 or 1 for Mask.
    pub fn opacity(&self, hit: &Hit) -> f32 {
        self.material(hit.object).opacity(&self.accel, &self.textures, hit)
    }

    /// Whether any object has a material of mode Mask or Blend that is not fully opaque.
    pub fn has_alpha(&self) -> bool {
        self.survey.has_alpha
    }

    /// Whether the material of an object is double-sided; with --cull-backfaces only back faces of such objects can be
    /// hit.
    pub fn is_double_sided(&self, object: u32) -> bool {
        self.material(object).double_sided
    }

    /// Approximate memory of the scene in bytes.
    pub fn memory_bytes(&self) -> usize {
        self.accel.memory_bytes()
            + self.textures.iter().map(Texture::memory_bytes).sum::<usize>()
            + self.lights.iter().map(Light::memory_bytes).sum::<usize>()
            + self.area.memory_bytes()
            + self.shared_places.as_ref().map_or(0, SharedPlaces::memory_bytes)
            + self.materials.capacity() * size_of::<TexturedMaterial>()
            + self.objects.iter().map(|o| size_of::<Object>() + o.name.len()).sum::<usize>()
    }

    fn emitter(&self, object: u32) -> Emitter<'_> {
        Emitter { accel: &self.accel, textures: &self.textures, material: self.material(object) }
    }
}

/// Sets the features in `survey` of the materials that objects use.
pub(crate) fn survey(objects: &[Object], materials: &[TexturedMaterial], survey: &mut Survey) {
    for material in objects.iter().map(|o| &materials[o.material as usize]) {
        survey.has_alpha |= material.alpha_mode != AlphaMode::Opaque;
        survey.has_textures |= material.textures().next().is_some();
        survey.has_transmission |= material.base.transmission > 0.0;
        survey.has_volume |= material.sigma_a != Vec3::ZERO;
        survey.has_normal_maps |= material.normal_texture.is_some();
        survey.has_unlit |= material.unlit;
    }
}
