//! Context of ray queries: the scene at a time, and what stops rays.

use crate::job::Job;
use crate::visibility::Visibility;
use dapple_math::Ray;
use dapple_sampling::Key;
use dapple_scene::Scene;

/// Data that ray queries need about the render, the time of the sample and the place of the ray.
#[derive(Clone, Copy)]
pub(crate) struct TraceContext<'a, V> {
    pub job: &'a Job<'a>,
    pub scene: &'a Scene,
    pub visibility: V,
    /// Seconds since the shutter opened.
    pub time: f32,
    /// Key of the alpha test of a ray.
    pub key: Key,
}

impl<V: Visibility> TraceContext<'_, V> {
    /// Whether `ray` is occluded.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.visibility.occluded(self.scene, ray, self.time, self.key)
    }
}
