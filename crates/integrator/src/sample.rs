//! One sample of one pixel: its numbers by name, and its camera ray.

use crate::settings::Settings;
use dapple_camera::Camera;
use dapple_geometry::Ray;
use dapple_sampling::{Dimension, Key, Pattern, padded_1d, padded_2d};
use glam::Vec2;

/// The s-th of n samples of a pixel. Every number it uses is a pure function of (key, s, n, depth, dimension).
#[derive(Clone, Copy)]
pub(crate) struct Sample {
    pub key: Key,
    pub s: u32,
    pub n: u32,
    pub pattern: Pattern,
    /// Seconds within the shutter.
    pub time: f32,
}

impl Sample {
    /// Sample `index` of pixel (x, y). With a sample count the n points form one set; without one (a time limit) they
    /// come in blocks, each a set of its own, so that whatever was finished is a fair estimate.
    pub fn new(settings: &Settings, x: u32, y: u32, index: u32) -> Self {
        let key = Key::pixel(settings.seed, x, y);
        let n = settings.block();
        match settings.pattern {
            Pattern::Sobol | Pattern::Random => {
                Self { key, s: index, n: n.max(index + 1), pattern: settings.pattern, time: 0.0 }
            }
            pattern => Self {
                key: if index < n { key } else { key.branch(index / n) },
                s: index % n,
                n,
                pattern,
                time: 0.0,
            },
        }
    }

    pub fn point_1d(&self, depth: u32, dimension: Dimension) -> f32 {
        padded_1d(self.pattern, self.s, self.n, self.key.at(depth, dimension))
    }

    pub fn point_2d(&self, depth: u32, dimension: Dimension) -> Vec2 {
        padded_2d(self.pattern, self.s, self.n, self.key.at(depth, dimension))
    }

    /// The camera ray through pixel (x, y), and the weight the pixel filter gives it.
    pub fn camera_ray(&self, settings: &Settings, camera: &Camera, x: u32, y: u32) -> (Ray, f32) {
        let (offset, weight) = settings.filter.sample(self.point_2d(0, Dimension::Pixel));
        let lens = if camera.lens.is_some() { self.point_2d(0, Dimension::Lens) } else { Vec2::splat(0.5) };
        (camera.ray((x, y), offset + Vec2::splat(0.5), settings.size, lens), weight)
    }
}
