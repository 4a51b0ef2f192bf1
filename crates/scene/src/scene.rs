//! The checked scene: everything a tracer reads. Render space throughout (see `space`).
use crate::{Space, Survey, TexturedMaterial, Warning};
use dapple_camera::Camera;
use dapple_geometry::{Frame, Hit, Surface, World};
use dapple_imaging::Texture;
use dapple_lights::{Light, LightChoice, LightPoint};
use dapple_materials::Material;
use glam::Vec3;
/// Names for reports and ids for AOVs; index = world object index.
#[derive(Clone, Debug)]
pub struct Object {
    pub name: String,
    pub material: u32,
    /** first area light of this object's triangles, u32::MAX = emits nothing */
    pub first_light: u32,
}
#[derive(Clone, Debug)]
pub struct NamedCamera {
    pub name: String,
    pub camera: Camera,
    /** width / height asked for by the file */
    pub aspect: Option<f32>,
}
#[derive(Debug)]
pub struct Scene {
    pub name: String,
    pub space: Space,
    pub world: World,
    pub objects: Vec<Object>,
    pub materials: Vec<TexturedMaterial>,
    pub textures: Vec<Texture>,
    pub lights: Vec<Light>,
    pub light_choice: Option<LightChoice>,
    /// Index of the environment in `lights`.
    pub environment: Option<u32>,
    pub cameras: Vec<NamedCamera>,
    pub survey: Survey,
    pub warnings: Vec<Warning>,
}
/// A hit with its textures looked up.
#[derive(Clone, Copy, Debug)]
pub struct Shading {
    /// z = shading normal (normal map applied) on the *front* side of the surface; consistent with `surface.ng`.
    pub frame: Frame,
    pub material: Material,
    pub sigma_a: Vec3,
    pub unlit: bool,
}
impl Scene {
    pub fn shading(&self, _hit: &Hit, _surface: &Surface) -> Shading {
        todo!()
    }
    /// Radiance emitted towards `wo` (unit, world): emissive texture, front side only unless double-sided.
    pub fn emission(&self, _hit: &Hit, _surface: &Surface, _wo: Vec3) -> Vec3 {
        todo!()
    }
    /// The area light a hit lies on.
    pub fn light_of(&self, _hit: &Hit) -> Option<u32> {
        todo!()
    }
    /// Radiance of area light `light` at a sampled place towards `wi` reversed (texture applied).
    pub fn light_radiance(&self, _light: u32, _point: &LightPoint, _mean: Vec3) -> Vec3 {
        todo!()
    }
    /// Opacity at a hit, 1 for opaque materials; Mask gives 0 or 1.
    pub fn opacity(&self, _hit: &Hit) -> f32 {
        todo!()
    }
    /// Any material with Mask or Blend.
    pub fn has_alpha(&self) -> bool {
        todo!()
    }
    /// Backfaces can be hit only when the material is double-sided (with --cull-backfaces).
    pub fn is_double_sided(&self, _object: u32) -> bool {
        todo!()
    }
    pub fn memory_bytes(&self) -> usize {
        todo!()
    }
}
