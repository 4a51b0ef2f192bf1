//! Pilot samples of an adaptive render, from which the sample allocation is computed.

use crate::allocation::{PILOT, SampleAllocation};
use crate::settings::Settings;
use crate::tile::Tile;
use dapple_camera::Film;
use dapple_math::PixelRect;
use std::sync::Arc;

/// Observes the passes of a render until the sample allocation is known.
#[derive(Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pilot {
    waiting: bool,
    half: Option<Film>,
    /// The sample allocation, known from the start or after the pilot samples.
    pub allocation: Option<Arc<SampleAllocation>>,
}

impl Pilot {
    pub fn new(settings: &Settings, tiles: &mut [Tile]) -> Self {
        let waiting = settings.is_adaptive();
        if waiting {
            tiles.iter_mut().for_each(|tile| tile.pixel_rays = vec![0; tile.rect.area()]);
        }
        Self { waiting, half: None, allocation: settings.allocation().cloned() }
    }

    /// Whether the pilot can be that of a render of `rect` whose start is `fresh`.
    pub fn is_like(&self, fresh: &Self, rect: PixelRect) -> bool {
        let is_whole = |film: &Film| film.rect() == rect && film.is_whole();
        self.half.as_ref().is_none_or(is_whole)
            && self.allocation.as_ref().is_none_or(|allocation| allocation.is_whole())
            && (fresh.waiting || self.allocation == fresh.allocation)
    }

    /// Sample count at which the pass after `spp` has to end for the pilot.
    pub fn next(&self, spp: u32) -> u32 {
        let stops = [PILOT / 2, PILOT];
        stops.into_iter().find(|stop| self.waiting && *stop > spp).unwrap_or(u32::MAX)
    }

    /// Records the films of all tiles after `spp` samples of every pixel.
    pub fn record(&mut self, spp: u32, rect: PixelRect, tiles: &[Tile]) {
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
