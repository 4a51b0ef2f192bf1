//! Rendering of individual pixels of an image.

use super::pool::Pool;
use super::watch;
use crate::batch::Batches;
use crate::job::Job;
use crate::kernel;
use crate::settings::Settings;
use crate::tile::Tile;
use dapple_camera::{Camera, SampleSums};
use dapple_math::PixelRect;
use dapple_scene::Scene;
use glam::DVec3;
use std::ops::Range;

/// The means of `pixels` after `spp` samples each, scaled by the sample allocation, in a render with `settings`, whose
/// limits are ignored.
pub fn render_pixels(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    spp: u32,
    pixels: &[(u32, u32)],
) -> Vec<DVec3> {
    render_pixels_until(scene, camera, settings, spp, pixels, &|| false).unwrap_or_default()
}

/// As [`render_pixels`]; returns `None` once `stop`, which is polled continuously, returns true.
pub fn render_pixels_until(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    spp: u32,
    pixels: &[(u32, u32)],
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<DVec3>> {
    let sums = sum_pixels_until(scene, camera, settings, 0..spp, pixels, stop)?;
    Some(sums.iter().map(|sums| sums.finish().1.mean).collect())
}

/// The sums of the samples with indices in `samples` of each of `pixels`, scaled by the sample allocation, in a render
/// with `settings`, whose limits are ignored; `None` once `stop`, which is polled continuously, returns true.
pub fn sum_pixels_until(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    samples: Range<u32>,
    pixels: &[(u32, u32)],
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<SampleSums>> {
    let tile = |&(x, y): &(u32, u32)| Tile::cut(PixelRect { x0: x, y0: y, x1: x + 1, y1: y + 1 }, settings);
    let mut tiles: Vec<Tile> = pixels.iter().flat_map(tile).collect();
    watch::until(stop, |stopped| {
        let job = Job { stop: stopped.clone(), ..Job::new(scene, camera, settings) };
        let (kernel, _) = kernel::choose(&job);
        let batches = Batches::new(&job, kernel);
        Pool::new(&settings.limits).each_tile(&mut tiles, |tile| {
            if !job.is_stopped() {
                let allocation = settings.allocation().map(|allocation| &**allocation);
                tile.render(&job, (kernel, batches.as_ref()), (samples.start, samples.end), allocation);
            }
        });
    });
    let is_done = |tile: &Tile| tile.next == samples.end;
    let sums = |tile: &Tile| is_done(tile).then(|| tile.film.sums_at(tile.rect.x0, tile.rect.y0));
    tiles.iter().map(sums).collect()
}
