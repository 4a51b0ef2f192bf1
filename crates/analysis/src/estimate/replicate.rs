//! The error from blocks of the picture that are rendered again with other seeds.
//!
//! A block that is drawn k times is rendered k times. Of the picture I and the mean Ī of the k others, k/(k+1)·(I − Ī)²
//! has the expectation of the squared error, and for large k it is the error that this picture has: where few blocks
//! make up most of the error, it is known well.

use super::blocks::{self, Block};
use super::{Estimate, level, sum_and_spread};
use dapple_integrator::camera::{Camera, Film, PixelRect};
use dapple_integrator::scene::Scene;
use dapple_integrator::{Checkpoint, Settings, render, render_watched};
use glam::DVec3;
use std::ops::ControlFlow;
use std::time::Duration;

/// One block of so many is rendered again.
const ONE_IN: usize = 32;
/// But at least so many.
const LEAST: usize = 64;

/// The error of `film`, a finished render of `settings`. Renders some blocks again: at most a thirty-second of the
/// picture, or 64 blocks of 8×8 pixels.
pub fn replicate(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    film: &Film,
    confidence: f64,
) -> Option<Estimate> {
    let within: Vec<f64> = film.variance().pixels.iter().map(|v| v.as_dvec3().element_sum()).collect();
    let rect = settings.rect();
    let draws = (blocks::count(rect) / ONE_IN).max(LEAST);
    let chosen = blocks::chosen(rect, &within, settings.seed, draws);
    let spp = film.count(rect.x0, rect.y0);
    let errors = |block: &Block| {
        let mut sum = vec![DVec3::ZERO; block.rect.area()];
        for k in 0..block.times {
            let film = again(scene, camera, &other(settings, block, k), spp);
            sum.iter_mut().zip(pixels(block.rect)).for_each(|(s, (x, y))| *s += film.mean_at(x, y));
        }
        squares(film, &sum, block)
    };
    let errors = blocks::each(&chosen, settings.threads, errors);
    let (sum, spread) = sum_and_spread(errors.into_iter().flatten());
    let mse = sum / (3 * within.len()) as f64;
    // The true error varies too, as far as few pixels make it up.
    let (known, within_spread) = sum_and_spread(within.iter().copied());
    let own = if known.is_finite() { within_spread } else { spread };
    Estimate::new(mse, mse, (spread + own).sqrt(), level(film.mean().mean()), confidence)
}

/// The same for one block, by other numbers, each time others.
fn other(settings: &Settings, block: &Block, k: u32) -> Settings {
    Settings {
        crop: Some(block.rect),
        seed: settings.seed ^ 0x5eed_5eed_5eed_5eed ^ (u64::from(k) << 32),
        threads: Some(1),
        aovs: Vec::new(),
        adaptive: false,
        // Sets that are repeated while there is time are stopped when they are as many.
        time_limit: settings.time_limit.map(|_| Duration::MAX),
        ..settings.clone()
    }
}

/// As many samples as the film has, `spp`, where the settings do not say how many.
fn again(scene: &Scene, camera: &Camera, settings: &Settings, spp: u64) -> Film {
    let go_on = &|_| ControlFlow::Continue(());
    if settings.samples().is_some() {
        return render(scene, camera, settings, go_on).film;
    }
    let mut look = |at: &Checkpoint<'_>| match u64::from(at.spp) >= spp {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    render_watched(scene, camera, settings, go_on, &mut look).film
}

/// Squared errors of the block's pixels, summed over channels and weighted; `sum` is of its other renders.
fn squares(film: &Film, sum: &[DVec3], block: &Block) -> Vec<f64> {
    let k = f64::from(block.times);
    let square = |((x, y), sum): ((u32, u32), &DVec3)| (film.mean_at(x, y) - *sum / k).length_squared();
    pixels(block.rect).zip(sum).map(|p| block.weight * k / (k + 1.0) * square(p)).collect()
}

fn pixels(r: PixelRect) -> impl Iterator<Item = (u32, u32)> {
    (r.y0..r.y1).flat_map(move |y| (r.x0..r.x1).map(move |x| (x, y)))
}
