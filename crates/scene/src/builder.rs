//! Scenes built in code: add things in world space, f64; `build` recentres, rescales, finds lights, checks.
use crate::{Scene, SceneError, TexturedMaterial, Warning};
use dapple_geometry::Mesh;
use dapple_imaging::Texture;
use dapple_lights::Environment;
use glam::{DAffine3, DVec3, Vec3};
#[derive(Debug, Default)]
pub struct SceneBuilder {}
/// A camera in world space.
#[derive(Clone, Copy, Debug)]
pub struct CameraPose {
    pub transform: DAffine3,
    pub projection: dapple_camera::Projection,
    pub aspect: Option<f32>,
}
impl SceneBuilder {
    pub fn new(_name: &str) -> Self {
        todo!()
    }
    pub fn texture(&mut self, _texture: Texture) -> u32 {
        todo!()
    }
    pub fn material(&mut self, _material: TexturedMaterial) -> u32 {
        todo!()
    }
    pub fn mesh(&mut self, _name: &str, _mesh: Mesh, _transform: DAffine3, _material: u32) -> u32 {
        todo!()
    }
    pub fn sphere(&mut self, _name: &str, _centre: DVec3, _radius: f64, _material: u32) -> u32 {
        todo!()
    }
    pub fn disk(&mut self, _name: &str, _centre: DVec3, _normal: DVec3, _radius: f64, _material: u32) -> u32 {
        todo!()
    }
    pub fn point_light(&mut self, _p: DVec3, _intensity: Vec3, _range: f64) {
        todo!()
    }
    pub fn spot_light(
        &mut self,
        _p: DVec3,
        _axis: DVec3,
        _intensity: Vec3,
        _range: f64,
        _inner: f64,
        _outer: f64,
    ) {
        todo!()
    }
    pub fn distant_light(&mut self, _towards: DVec3, _irradiance: Vec3) {
        todo!()
    }
    pub fn environment(&mut self, _environment: Environment) {
        todo!()
    }
    pub fn camera(&mut self, _name: &str, _pose: CameraPose) {
        todo!()
    }
    pub fn warn(&mut self, _warning: Warning) {
        todo!()
    }
    /// Adds a framing camera when there is none, a white environment (with a warning) when nothing emits.
    pub fn build(self) -> Result<Scene, SceneError> {
        todo!()
    }
}
