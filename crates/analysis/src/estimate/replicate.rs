//! The error from blocks of the picture that are rendered once more with another seed.

use super::{Estimate, level, sum_and_spread};
use dapple_integrator::camera::{Camera, Film, PixelRect};
use dapple_integrator::sampling::Key;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Settings, render};
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Side of a block in pixels.
const SIDE: u32 = 8;
/// One block of so many is rendered again.
const ONE_IN: usize = 32;
/// But at least so many, or all there are.
const LEAST: usize = 12;

/// The error of `film`, a finished render of `settings` with `samples` per pixel. Renders some blocks again: about a
/// thirty-second of the picture's time, more for pictures of less than 400 blocks of 8×8 pixels.
pub fn replicate(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    film: &Film,
    confidence: f64,
) -> Option<Estimate> {
    let blocks = chosen(settings.rect(), settings.seed);
    let pixels = again(scene, camera, settings, film, &blocks);
    let (sum, spread) = sum_and_spread(pixels.iter().map(|p| p.square));
    let known: f64 = pixels.iter().map(|p| p.within).sum();
    let highest = pixels.iter().map(|p| p.within).fold(0.0, f64::max);
    let all: Vec<f64> = film.variance().pixels.iter().map(|v| v.as_dvec3().element_sum()).collect();
    let (within, within_spread) = sum_and_spread(all.iter().copied());
    let mse = if known > 0.0 && within.is_finite() {
        // The variance within pixels says how errors are spread over the picture, the blocks how much of it is true.
        // Pixels above all that the blocks have seen are believed in full.
        let ratio = (sum / known).min(1.0);
        let scaled = |v: &f64| if *v > highest { *v } else { *v * ratio };
        all.iter().map(scaled).sum::<f64>() / (3 * all.len()) as f64
    } else {
        sum / (3 * pixels.len()) as f64
    };
    let within_spread = if within.is_finite() { within_spread } else { spread };
    Estimate::new(mse, mse, (spread + within_spread).sqrt(), level(film.mean().mean()), confidence)
}

/// What two renders of a pixel say.
struct Pixel {
    /// Half their squared difference, summed over channels.
    square: f64,
    /// The variance within the pixel.
    within: f64,
}

/// Blocks of `rect`, spread over it, one at random in each of equally long stretches.
fn chosen(rect: PixelRect, seed: u64) -> Vec<PixelRect> {
    let columns = rect.width().div_ceil(SIDE) as usize;
    let count = columns * rect.height().div_ceil(SIDE) as usize;
    let wanted = (count / ONE_IN).max(LEAST).min(count);
    let place = |j: usize| {
        let u = (Key::pixel(seed, j as u32, 0xb10c).bits() >> 11) as f64 / (1u64 << 53) as f64;
        ((j as f64 + u) * count as f64 / wanted as f64) as usize
    };
    let block = |i: usize| {
        let (x0, y0) = (rect.x0 + (i % columns) as u32 * SIDE, rect.y0 + (i / columns) as u32 * SIDE);
        PixelRect { x0, y0, x1: (x0 + SIDE).min(rect.x1), y1: (y0 + SIDE).min(rect.y1) }
    };
    (0..wanted).map(|j| block(place(j).min(count - 1))).collect()
}

/// Renders the blocks with another seed, as many at a time as there are threads.
fn again(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    film: &Film,
    blocks: &[PixelRect],
) -> Vec<Pixel> {
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        while let Some(block) = blocks.get(next.fetch_add(1, Ordering::Relaxed)) {
            let settings = Settings {
                crop: Some(*block),
                seed: settings.seed ^ 0x5eed_5eed_5eed_5eed,
                threads: Some(1),
                aovs: Vec::new(),
                time_limit: None,
                ..settings.clone()
            };
            let other = render(scene, camera, &settings, &|_| ControlFlow::Continue(())).film;
            let pixels = compare(film, &other, *block);
            if let Ok(mut found) = found.lock() {
                found.push((block.y0, block.x0, pixels));
            }
        }
    };
    std::thread::scope(|scope| {
        let threads = settings.threads.unwrap_or(1).clamp(1, blocks.len().max(1));
        (1..threads).for_each(|_| drop(scope.spawn(work)));
        work();
    });
    let mut found = found.into_inner().unwrap_or_default();
    // Sums must not depend on who was first.
    found.sort_by_key(|(y, x, _)| (*y, *x));
    found.into_iter().flat_map(|(_, _, pixels)| pixels).collect()
}

fn compare(film: &Film, other: &Film, block: PixelRect) -> Vec<Pixel> {
    let mut part = Film::new(block);
    part.put(film);
    let variances = part.variance().pixels.into_iter().zip(other.variance().pixels);
    let within = |(a, b): (Vec3, Vec3)| 0.5 * (a.as_dvec3() + b.as_dvec3()).element_sum();
    let pixels = (block.y0..block.y1).flat_map(|y| (block.x0..block.x1).map(move |x| (x, y)));
    let square = |(x, y)| {
        let d: DVec3 = film.mean_at(x, y) - other.mean_at(x, y);
        0.5 * d.length_squared()
    };
    pixels.map(square).zip(variances.map(within)).map(|(square, within)| Pixel { square, within }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_lie_within_and_are_spread() {
        let rect = PixelRect { x0: 3, y0: 5, x1: 515, y1: 517 };
        let blocks = chosen(rect, 7);
        assert_eq!(blocks.len(), 128);
        assert!(blocks.iter().all(|b| b.x1 <= rect.x1 && b.y1 <= rect.y1 && b.area() == 64));
        assert_eq!(blocks.iter().filter(|b| b.y0 < 5 + 256).count(), 64);
        let small = PixelRect { x0: 0, y0: 0, x1: 10, y1: 3 };
        assert_eq!(chosen(small, 0).iter().map(PixelRect::area).sum::<usize>(), 30);
        assert_ne!(chosen(rect, 1), chosen(rect, 2));
    }
}
