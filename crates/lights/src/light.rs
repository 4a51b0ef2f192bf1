//! One light of any kind: sample towards it, density of a direction that reaches it.
use crate::{Area, Distant, Environment, Point, Spot};
use glam::{Vec2, Vec3};
#[derive(Clone, Debug)]
pub enum Light {
    Point(Point),
    Spot(Spot),
    Distant(Distant),
    Area(Area),
    Environment(Environment),
}
/// A place on an area light.
#[derive(Clone, Copy, Debug)]
pub struct LightPoint {
    pub p: Vec3,
    pub p_error: Vec3,
    /// Unit geometric normal of the front side.
    pub n: Vec3,
    /// Which triangle of the shape (quad: 0 or 1) and its barycentrics, for textured emission.
    pub triangle: u32,
    pub u: f32,
    pub v: f32,
}
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// Solid-angle density at the receiver; 1 for delta lights.
    pub pdf: f32,
    pub delta: bool,
    /// Radiance along −wi (area: the light's mean; delta: intensity/d², i.e. irradiance on a facing surface).
    pub radiance: Vec3,
    /// Distance to the light; infinite for distant and environment.
    pub distance: f32,
    /// Only for area lights.
    pub point: Option<LightPoint>,
}
impl Light {
    /// None when the light cannot reach `p` (behind a one-sided emitter, in its plane, density 0).
    pub fn sample(&self, _p: Vec3, _u: Vec2) -> Option<LightSample> {
        todo!()
    }
    /// Solid-angle density at `p` with which `sample` gives the direction `wi` (unit) that was seen to reach this light
    /// at distance `distance` with geometric normal `n` there. 0 for delta lights.
    pub fn pdf(&self, _p: Vec3, _wi: Vec3, _distance: f32, _n: Vec3) -> f32 {
        todo!()
    }
    /// Total power in W per channel (environment: through a disk of the scene's radius).
    pub fn power(&self, _scene_radius: f32) -> Vec3 {
        todo!()
    }
    pub fn is_delta(&self) -> bool {
        todo!()
    }
}
