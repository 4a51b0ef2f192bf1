//! Which light to aim at.
use crate::Light;
use dapple_sampling::discrete::Choice;
use glam::Vec3;
/// None of its pmfs is 0 for a light that can contribute.
#[derive(Clone, Debug)]
pub struct LightChoice {}
impl LightChoice {
    /// `lights` in the order they are addressed by; lights that never need aiming at (constant environment) get pmf 0.
    /// None when no light can be aimed at.
    pub fn new(_lights: &[Light], _scene_radius: f32) -> Option<Self> {
        todo!()
    }
    /// Chooses for a receiver at `p` with normal `n` (zero = no normal).
    pub fn sample(&self, _p: Vec3, _n: Vec3, _uc: f32) -> Option<Choice> {
        todo!()
    }
    pub fn pmf(&self, _p: Vec3, _n: Vec3, _light: usize) -> f32 {
        todo!()
    }
}
