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
    judged(&chosen, &errors, &within, level(film.mean().mean()), confidence)
}

/// From the squared errors of the `chosen` blocks' pixels, weighted, and the variances `within` all pixels, both summed
/// over channels.
fn judged(
    chosen: &[Block],
    errors: &[Vec<f64>],
    within: &[f64],
    level: f64,
    confidence: f64,
) -> Option<Estimate> {
    let (sum, noise) = sum_and_spread(errors.iter().flatten().copied());
    let mse = sum / (3 * within.len()) as f64;
    let whole = chosen.iter().map(|b| b.rect.area()).sum::<usize>() == within.len();
    let blocks: Vec<f64> = errors.iter().map(|e| e.iter().sum()).collect();
    // Differences between blocks have the noise of their pixels in them.
    let spread = if whole { noise } else { noise.max(blocks::spread(chosen, &blocks)) };
    // The true error varies too, as far as few pixels make it up.
    let (known, within_spread) = sum_and_spread(within.iter().copied());
    let own = if known.is_finite() { within_spread } else { spread };
    Estimate::new(mse, mse, (spread + own).sqrt(), level, confidence)
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

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_integrator::sampling::Key;
    use dapple_testkit::Rng;

    /// A picture of independent pixel errors, whose deviations follow `deviation` and are known by their variances within
    /// pixels but for a factor that varies by block, is judged 500 times: how often is its true error within the bound?
    fn held(rect: PixelRect, deviation: impl Fn(u32, u32) -> f64) -> f64 {
        let factor = |x: u32, y: u32| 1.0 + (Key::pixel(3, x / 8, y / 8).bits() >> 61) as f64;
        let variance = |(x, y): (u32, u32)| deviation(x, y).powi(2);
        let within: Vec<f64> = pixels(rect).map(|(x, y)| 3.0 * factor(x, y) * variance((x, y))).collect();
        let mut rng = Rng::new(5);
        let held = (0..500u64).filter(|seed| {
            let mut normal = || rng.normal();
            let errors: Vec<f64> = pixels(rect).map(|p| variance(p).sqrt() * normal()).collect();
            let truth = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
            let chosen = blocks::chosen(rect, &within, *seed, LEAST);
            let mut square = |b: &Block, p: (u32, u32)| {
                let k = f64::from(b.times);
                let other = variance(p).sqrt() * normal() / k.sqrt();
                let mine = errors[(p.1 * rect.width() + p.0) as usize];
                b.weight * 3.0 * k / (k + 1.0) * (mine - other).powi(2)
            };
            let mut of = |b: &Block| pixels(b.rect).map(|p| square(b, p)).collect();
            let all: Vec<Vec<f64>> = chosen.iter().map(&mut of).collect();
            judged(&chosen, &all, &within, 1.0, 0.95).unwrap().bound >= truth.sqrt()
        });
        held.count() as f64 / 500.0
    }

    /// 95 % of 500 trials less four standard errors is 91.1 %.
    #[test]
    fn bounds_hold_as_often_as_they_promise() {
        let rect = |x1, y1| PixelRect { x0: 0, y0: 0, x1, y1 };
        let even = held(rect(128, 96), |_, _| 1.0);
        let edges = held(rect(128, 96), |x, y| if (x + y) % 40 < 3 { 1.0 } else { 0.02 });
        let corner = held(rect(96, 64), |x, y| if x < 6 && y < 6 { 1.0 } else { 0.05 });
        let small = held(rect(24, 24), |x, _| 1.0 + f64::from(x));
        for (name, share) in [("even", even), ("edges", edges), ("corner", corner), ("small", small)] {
            println!("{name}: {share}");
            assert!(share >= 0.911, "{name}: {share}");
        }
    }
}
