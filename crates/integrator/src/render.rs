//! The render loop: tiles, threads, passes, limits.
use crate::Settings;
use dapple_camera::{Camera, Film};
use dapple_imaging::Layers;
use dapple_scene::Scene;
use std::ops::ControlFlow;
use std::time::Duration;
/// Told a few times a second.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    pub fraction: f64,
    pub spp: u32,
    pub rays: u64,
    pub elapsed: Duration,
}
#[derive(Clone, Debug, Default)]
pub struct Stats {
    pub seconds: f64,
    pub samples: u64,
    pub rays: u64,
    pub spp: u32,
    pub threads: usize,
    pub kernel: String,
    pub bad_samples: Vec<BadSample>,
    pub bad_sample_count: u64,
}
/// A sample that was not finite: replay it with `dapple replay --pixel x,y --sample s`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadSample {
    pub x: u32,
    pub y: u32,
    pub sample: u32,
}
#[derive(Debug)]
pub struct Outcome {
    pub film: Film,
    /** beauty + AOVs, metadata empty */
    pub layers: Layers,
    pub stats: Stats,
}
/// Renders. `progress` may stop the render early by returning Break: whole passes so far are kept.
pub fn render(
    _scene: &Scene,
    _camera: &Camera,
    _settings: &Settings,
    _progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Outcome {
    todo!()
}
