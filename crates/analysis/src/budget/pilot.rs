//! A few samples of a picture, from which the rest is predicted.

use super::blocks::{self, Block};
use dapple_integrator::camera::Camera;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Method, Outcome, Settings, Variances, render, variances};
use std::ops::ControlFlow;

/// Samples of every pixel, by the path tracer.
const FIRST: u32 = 8;

/// Blocks that stand for the picture, and their side in pixels.
const BLOCKS: usize = 96;
const SIDE: u32 = 8;

/// Pairs of samples per pixel of a block for the split by effect.
const PAIRS: u32 = 4;

/// A picture of few samples, and blocks of it.
pub(super) struct Pilot<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    settings: &'a Settings,
    blocks: Vec<Block>,
    /// Mean radiance of three channels.
    pub mean: f64,
    /// Rays and seconds of one sample of every pixel, by the path tracer.
    pub path_cost: (f64, f64),
}

impl<'a> Pilot<'a> {
    pub fn new(scene: &'a Scene, camera: &'a Camera, settings: &'a Settings) -> Self {
        let first = Settings { method: Method::Path, spp: Some(FIRST), ..plain(settings) };
        let outcome = render(scene, camera, &first, &|_| ControlFlow::Continue(()));
        let within: Vec<f64> =
            outcome.film.variance().pixels.iter().map(|v| v.as_dvec3().element_sum()).collect();
        let mean = outcome.film.mean().mean();
        Self {
            scene,
            camera,
            settings,
            blocks: blocks::chosen(settings.rect(), SIDE, &within, settings.seed, BLOCKS),
            mean: f64::from(mean.x + mean.y + mean.z) / 3.0,
            path_cost: cost(&outcome, FIRST),
        }
    }

    /// How many blocks there are.
    pub fn chosen(&self) -> usize {
        self.blocks.len()
    }

    /// Of each block, what its effects make of the picture's mean variance.
    pub fn variances(&self) -> Vec<Variances> {
        let one = |block: &Block| {
            let settings = Settings { seed: self.settings.seed ^ 0xb0d6_e700, ..plain(self.settings) };
            let share = self.share(block);
            let mut found = variances(self.scene, self.camera, &settings, block.rect, PAIRS);
            found.parts.iter_mut().for_each(|v| *v *= share);
            found.more_rays.iter_mut().for_each(|v| *v *= share);
            (found.rest, found.rays) = (found.rest * share, found.rays * share);
            found
        };
        blocks::each(&self.blocks, self.settings.threads, one)
    }

    /// Of each block, its part of the picture's mean squared error, summed over channels, when rendered by `settings`:
    /// half the squared difference of two seeds.
    pub fn errors(&self, settings: &Settings) -> Vec<f64> {
        let one = |block: &Block| {
            let of = |seed: u64| {
                let other = Settings { crop: Some(block.rect), threads: Some(1), seed, ..plain(settings) };
                render(self.scene, self.camera, &other, &|_| ControlFlow::Continue(())).film
            };
            let (a, b) = (of(settings.seed ^ 0xb0d6_e701), of(settings.seed ^ 0xb0d6_e702));
            let r = block.rect;
            let pixels = (r.y0..r.y1).flat_map(|y| (r.x0..r.x1).map(move |x| (x, y)));
            let half = |(x, y)| 0.5 * (a.mean_at(x, y) - b.mean_at(x, y)).length_squared();
            self.share(block) * pixels.map(half).sum::<f64>() / r.area() as f64
        };
        blocks::each(&self.blocks, self.settings.threads, one)
    }

    /// Of a mean over the picture, what the mean over a block counts.
    fn share(&self, block: &Block) -> f64 {
        block.weight * block.rect.area() as f64 / self.settings.rect().area() as f64
    }

    /// Rays and seconds of the whole picture by `settings`, which take one sample of every pixel.
    pub fn cost(&self, settings: &Settings) -> (f64, f64) {
        cost(&render(self.scene, self.camera, &plain(settings), &|_| ControlFlow::Continue(())), 1)
    }
}

fn cost(outcome: &Outcome, samples: u32) -> (f64, f64) {
    let n = f64::from(samples);
    (outcome.stats.rays as f64 / n, outcome.stats.seconds / n)
}

/// Without limits, layers and shares.
fn plain(settings: &Settings) -> Settings {
    Settings { aovs: Vec::new(), time_limit: None, adaptive: false, spread: None, ..settings.clone() }
}
