//! Pilot renders, from which the cost of the full render is predicted.
//!
//! The unit of the pilot is a *group*: a few blocks that represent the image on their own, drawn and rendered
//! independently of those of other groups. The variation between groups determines the confidence of a prediction,
//! whether blocks are part of a large image or all of a small one, and more groups increase it.

use super::shares::sum;
use crate::estimate::blocks::{self, Block};
use dapple_integrator::camera::Camera;
use dapple_integrator::scene::Scene;
use dapple_integrator::{MethodKind, Outcome, Settings, Variances, render, variances};
use std::ops::{ControlFlow, Range};

/// Minimum number of samples of the whole image, and of each pixel, by the path tracer.
const FIRST: usize = 1 << 16;
const FEWEST: usize = 8;

/// Number of blocks in a group, and their side in pixels.
const BLOCKS: usize = 12;
const SIDE: u32 = 8;

/// Pairs of samples per pixel of a block for the split by effect.
const PAIRS: u32 = 4;

/// Samples of the image from which its render time is measured.
const TIMED: usize = 1 << 14;

/// An image of few samples, and the renders of blocks drawn from it.
pub(super) struct Pilot<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    settings: &'a Settings,
    /// Variance within every pixel.
    within: Vec<f64>,
    /// Mean radiance of three channels.
    pub mean: f64,
    /// Relative standard error of `mean`.
    pub mean_error: f64,
    /// Rays and seconds of one sample of every pixel, by the path tracer.
    pub path_cost: (f64, f64),
}

impl<'a> Pilot<'a> {
    pub fn new(scene: &'a Scene, camera: &'a Camera, settings: &'a Settings) -> Self {
        let area = settings.rect().area().max(1);
        let spp = FIRST.div_ceil(area).clamp(FEWEST, FIRST) as u32;
        let first = plain(settings).with_method(MethodKind::Path).with_spp(spp);
        let outcome = render(scene, camera, &first, &|_| ControlFlow::Continue(()));
        // The variance of the mean of a pixel's samples. Only its proportions matter for drawing blocks, and those
        // equal the proportions for single samples.
        let within: Vec<f64> =
            outcome.film.variance().pixels.iter().map(|v| v.as_dvec3().element_sum()).collect();
        let mean = outcome.film.mean().mean();
        let mean = f64::from(mean.x + mean.y + mean.z) / 3.0;
        // The mean of three channels varies at most as much as if the channels were fully correlated.
        let mean_error = (within.iter().sum::<f64>() / 3.0).sqrt() / area as f64 / mean;
        Self { scene, camera, settings, within, mean, mean_error, path_cost: cost(&outcome, spp) }
    }

    /// Number of pixels of a group.
    pub fn group_area(&self) -> f64 {
        let all = self.settings.rect().area() as f64;
        f64::min(all, BLOCKS as f64 * f64::from(SIDE * SIDE))
    }

    /// Number of pixels of the image.
    pub fn area(&self) -> f64 {
        self.settings.rect().area() as f64
    }

    /// The blocks of the given groups, each with the number of its group.
    fn blocks(&self, groups: Range<u32>) -> (Vec<u32>, Vec<Block>) {
        let (mut of, mut all) = (Vec::new(), Vec::new());
        for group in groups {
            let seed = self.settings.seed ^ (u64::from(group) << 32);
            let blocks = blocks::chosen(self.settings.rect(), SIDE, &self.within, seed, BLOCKS);
            of.extend(std::iter::repeat_n(group, blocks.len()));
            all.extend(blocks);
        }
        (of, all)
    }

    /// For each group, the mean variance of the image, split by effect.
    pub fn variances(&self, groups: Range<u32>) -> Vec<Variances> {
        let one = |group: u32, block: &Block| {
            let seed = (self.settings.seed ^ 0xb0d6_e700) + (u64::from(group) << 32);
            let settings = Settings { seed, ..plain(self.settings) };
            let share = self.share(block);
            let mut found = variances(self.scene, self.camera, &settings, block.rect, PAIRS);
            found.parts.iter_mut().for_each(|v| *v *= share);
            found.more_rays.iter_mut().for_each(|v| *v *= share);
            (found.rest, found.rays) = (found.rest * share, found.rays * share);
            found
        };
        self.each(groups, one).into_iter().map(|all| sum(&all)).collect()
    }

    /// For each group, an estimate of the mean squared error of the image with `settings`, summed over channels: half
    /// the squared difference of two seeds.
    pub fn errors(&self, settings: &Settings, groups: Range<u32>) -> Vec<f64> {
        let one = |group: u32, block: &Block| {
            let of = |seed: u64| {
                let seed = (settings.seed ^ seed) + (u64::from(group) << 32);
                let other = Settings { crop: Some(block.rect), seed, ..plain(settings) }.with_threads(1);
                render(self.scene, self.camera, &other, &|_| ControlFlow::Continue(())).film
            };
            let (a, b) = (of(0xb0d6_e701), of(0xb0d6_e702));
            let r = block.rect;
            let pixels = (r.y0..r.y1).flat_map(|y| (r.x0..r.x1).map(move |x| (x, y)));
            let half = |(x, y)| 0.5 * (a.mean_at(x, y) - b.mean_at(x, y)).length_squared();
            self.share(block) * pixels.map(half).sum::<f64>() / r.area() as f64
        };
        self.each(groups, one).into_iter().map(|all| all.iter().sum()).collect()
    }

    /// Applies `work` to every block of the given groups; returns the results by group.
    fn each<T: Send>(&self, groups: Range<u32>, work: impl Fn(u32, &Block) -> T + Sync) -> Vec<Vec<T>> {
        let first = groups.start;
        let mut found: Vec<Vec<T>> = groups.clone().map(|_| Vec::new()).collect();
        let (of, all) = self.blocks(groups);
        // The index of a block determines its group.
        let indexed: Vec<(u32, Block)> = of.into_iter().zip(all).collect();
        let results =
            blocks::each(&indexed, self.settings.limits.threads, |(group, block)| work(*group, block));
        for ((group, _), result) in indexed.iter().zip(results) {
            found[(group - first) as usize].push(result);
        }
        found
    }

    /// The weight of the mean over a block in the mean over the image.
    fn share(&self, block: &Block) -> f64 {
        block.weight * block.rect.area() as f64 / self.area()
    }

    /// Rays and seconds of the whole image per point of `settings`, measured with enough points for a reliable time;
    /// with one point if `only_one`.
    pub fn cost(&self, settings: &dyn Fn(u32) -> Settings, only_one: bool) -> (f64, f64) {
        let points = TIMED.div_ceil(self.settings.rect().area().max(1)).clamp(1, 256) as u32;
        let points = if only_one { 1 } else { points };
        cost(
            &render(self.scene, self.camera, &plain(&settings(points)), &|_| ControlFlow::Continue(())),
            points,
        )
    }
}

fn cost(outcome: &Outcome, samples: u32) -> (f64, f64) {
    let n = f64::from(samples);
    (outcome.stats.rays as f64 / n, outcome.stats.seconds / n)
}

/// The settings without limits, AOVs, adaptive sampling and sample allocation.
fn plain(settings: &Settings) -> Settings {
    Settings { aovs: Vec::new(), ..settings.clone() }
        .with_time_limit(None)
        .with_path(|p| p.adaptive = false)
        .with_path(|p| p.allocation = None)
}
