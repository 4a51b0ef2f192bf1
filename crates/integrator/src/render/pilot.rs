//! Pilot samples: the first samples of every pixel, which decide where further ones go. The sample allocation of an
//! adaptive render is computed from them, and the pixels that are rendered again to estimate the error are drawn by
//! their variances. They are the same for every part of a render, so that a part that does not begin with them renders
//! them too, and drops them.

use crate::allocation::{PILOT, SampleAllocation};
use crate::settings::Settings;
use crate::tile::Tile;
use dapple_camera::Film;
use dapple_math::PixelRect;
use std::sync::Arc;

/// What the pilot samples of a render decide.
#[derive(Clone, Debug, Default)]
pub struct PilotResult {
    /// The variance of the mean of each pixel, summed over the channels, row by row; none if the distribution tracer
    /// has more than [`PILOT`](crate::PILOT) points per pixel, of which the first ones are not spread evenly.
    pub variance: Option<Arc<Vec<f32>>>,
    /// The sample allocation of an adaptive render.
    pub allocation: Option<Arc<SampleAllocation>>,
}

/// Observes the passes of a render until the sample allocation is known.
#[derive(Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pilot {
    waiting: bool,
    half: Option<Film>,
    /// The sample allocation, known from the start or after the pilot samples.
    pub allocation: Option<Arc<SampleAllocation>>,
    /// Number of samples after which the variances are recorded; 0 if they are not.
    count: u32,
    /// The variance of the mean of each pixel after the pilot samples, summed over channels.
    pub variance: Option<Arc<Vec<f32>>>,
}

impl Pilot {
    pub fn new(settings: &Settings, tiles: &mut [Tile]) -> Self {
        let waiting = settings.is_adaptive();
        if waiting {
            tiles.iter_mut().for_each(|tile| tile.pixel_rays = vec![0; tile.rect.area()]);
        }
        let has_first = settings.sample_range().start == 0;
        let count = settings.pilot_samples().filter(|_| has_first).unwrap_or_default();
        Self { waiting, half: None, allocation: settings.allocation().cloned(), count, variance: None }
    }

    /// Whether the pilot can be that of a render of `rect` whose start is `fresh`.
    pub fn is_like(&self, fresh: &Self, rect: PixelRect) -> bool {
        let is_whole = |film: &Film| film.rect() == rect && film.is_whole();
        self.half.as_ref().is_none_or(is_whole)
            && self.allocation.as_ref().is_none_or(|allocation| allocation.is_whole())
            && self.variance.as_ref().is_none_or(|variance| variance.len() == rect.area())
            && self.count == fresh.count
            && (fresh.waiting || self.allocation == fresh.allocation)
    }

    /// Sample count at which the pass after `spp` has to end for the pilot.
    pub fn next(&self, spp: u32) -> u32 {
        let stops = [(PILOT / 2, self.waiting), (PILOT, self.waiting), (self.count, true)];
        let later = stops.into_iter().filter(|(stop, applies)| *applies && *stop > spp);
        later.map(|(stop, _)| stop).min().unwrap_or(u32::MAX)
    }

    /// Records the films of all tiles after `spp` samples of every pixel.
    pub fn record(&mut self, spp: u32, rect: PixelRect, tiles: &[Tile]) {
        if spp == self.count {
            self.variance = Some(Arc::new(variance(rect, tiles)));
        }
        if !self.waiting {
            return;
        }
        if spp == PILOT / 2 {
            self.half = Some(film(rect, tiles));
        }
        if let Some(half) = self.half.as_ref().filter(|_| spp == PILOT) {
            self.allocation =
                Some(Arc::new(SampleAllocation::decide(half, &film(rect, tiles), &rays(rect, tiles))));
            self.waiting = false;
        }
    }
}

fn film(rect: PixelRect, tiles: &[Tile]) -> Film {
    let mut film = Film::new(rect);
    tiles.iter().for_each(|tile| film.put(&tile.film));
    film
}

/// Variance of the mean of every pixel, summed over channels, row by row.
fn variance(rect: PixelRect, tiles: &[Tile]) -> Vec<f32> {
    let mut all = vec![0.0; rect.area()];
    for tile in tiles {
        let width = tile.rect.width().max(1) as usize;
        for (y, row) in tile.film.variance().pixels.chunks(width).enumerate() {
            let at = ((tile.rect.y0 - rect.y0) as usize + y) * rect.width() as usize;
            let at = at + (tile.rect.x0 - rect.x0) as usize;
            all[at..].iter_mut().zip(row).for_each(|(to, from)| *to = from.element_sum());
        }
    }
    all
}

/// Rays of every pixel, row by row.
fn rays(rect: PixelRect, tiles: &[Tile]) -> Vec<u64> {
    let mut all = vec![0; rect.area()];
    for tile in tiles {
        for (i, rays) in tile.pixel_rays.iter().enumerate() {
            let (x, y) = (i % tile.rect.width() as usize, i / tile.rect.width() as usize);
            let row = (tile.rect.y0 - rect.y0) as usize + y;
            all[row * rect.width() as usize + (tile.rect.x0 - rect.x0) as usize + x] = *rays;
        }
    }
    all
}
