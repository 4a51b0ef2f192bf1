//! One path again, vertex by vertex.
use crate::Settings;
use dapple_camera::Camera;
use dapple_scene::Scene;
use glam::Vec3;
/// World-space vertex of a replayed path.
#[derive(Clone, Debug)]
pub struct PathVertex {
    pub kind: String,
    pub object: String,
    pub material: String,
    pub p: glam::DVec3,
    pub n: Vec3,
    pub lobe: String,
    pub pdf: f32,
    pub beta: Vec3,
    pub emitted: Vec3,
    pub direct: Vec3,
}
/// The path of sample `sample` of pixel (x, y), and its radiance.
pub fn replay(
    _scene: &Scene,
    _camera: &Camera,
    _settings: &Settings,
    _pixel: (u32, u32),
    _sample: u32,
) -> (Vec<PathVertex>, Vec3) {
    todo!()
}
