//! Which variant of the sample loop a render runs: one table, chosen once per render.

use crate::path::{self, Follow, Unwatched};
use crate::sample::Sample;
use crate::settings::Settings;
use crate::tile::FirstHit;
use crate::visibility::{Cutout, Solid, Visibility};
use dapple_camera::Camera;
use dapple_scene::Scene;
use glam::Vec3;

/// What is the same for all samples of a render.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub scene: &'a Scene,
    pub camera: &'a Camera,
    pub settings: &'a Settings,
}

/// Radiance and filter weight of sample `index` of pixel (x, y); fills `first` if the kernel watches the first hit.
pub(crate) type Kernel =
    fn(&Job<'_>, x: u32, y: u32, index: u32, first: &mut FirstHit, rays: &mut u64) -> (Vec3, f32);

/// The smallest kernel that covers the job, and its name.
pub(crate) fn choose(job: &Job<'_>) -> (Kernel, &'static str) {
    let cutout = job.scene.has_alpha() || job.settings.cull_backfaces;
    let watched = job.settings.aovs.iter().any(|aov| aov.needs_first_hit());
    match (cutout, watched) {
        (false, false) => (solid, "path"),
        (false, true) => (solid_watched, "path+first-hit"),
        (true, false) => (cutout_, "path+alpha"),
        (true, true) => (cutout_watched, "path+alpha+first-hit"),
    }
}

fn solid(job: &Job<'_>, x: u32, y: u32, index: u32, _: &mut FirstHit, rays: &mut u64) -> (Vec3, f32) {
    sample(job, Solid, x, y, index, &mut Unwatched, rays)
}

fn solid_watched(
    job: &Job<'_>,
    x: u32,
    y: u32,
    index: u32,
    first: &mut FirstHit,
    rays: &mut u64,
) -> (Vec3, f32) {
    sample(job, Solid, x, y, index, first, rays)
}

fn cutout_(job: &Job<'_>, x: u32, y: u32, index: u32, _: &mut FirstHit, rays: &mut u64) -> (Vec3, f32) {
    sample(job, Cutout { cull_backfaces: job.settings.cull_backfaces }, x, y, index, &mut Unwatched, rays)
}

fn cutout_watched(
    job: &Job<'_>,
    x: u32,
    y: u32,
    index: u32,
    first: &mut FirstHit,
    rays: &mut u64,
) -> (Vec3, f32) {
    sample(job, Cutout { cull_backfaces: job.settings.cull_backfaces }, x, y, index, first, rays)
}

/// One sample from pixel to radiance, with whoever follows it.
#[inline(always)]
pub(crate) fn sample<V: Visibility, F: Follow>(
    job: &Job<'_>,
    visibility: V,
    x: u32,
    y: u32,
    index: u32,
    follow: &mut F,
    rays: &mut u64,
) -> (Vec3, f32) {
    let sample = Sample::new(job.settings, x, y, index);
    let (ray, weight) = sample.camera_ray(job.settings, job.camera, x, y);
    (path::li(job.scene, job.settings, visibility, ray, &sample, follow, rays), weight)
}
