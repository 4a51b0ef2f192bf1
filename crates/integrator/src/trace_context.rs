//! What a ray is traced in: the scene at an instant, and what of it stops rays.

use crate::job::Job;
use crate::visibility::Visibility;
use dapple_math::Ray;
use dapple_sampling::Key;
use dapple_scene::Scene;

/// What rays need to know of a render, of the sample's time and of the place that they leave.
#[derive(Clone, Copy)]
pub(crate) struct TraceContext<'a, V> {
    pub job: &'a Job<'a>,
    pub scene: &'a Scene,
    pub visibility: V,
    /// Seconds within the shutter.
    pub time: f32,
    /// Of the alpha that a ray meets.
    pub key: Key,
}

impl<V: Visibility> TraceContext<'_, V> {
    /// Whether anything is in the way of `ray`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.visibility.occluded(self.scene, ray, self.time, self.key)
    }
}
