//! Snapshots of a render in progress.

use crate::allocation::SampleAllocation;
use crate::settings::Settings;
use crate::tail::Tail;
use crate::tile::Tile;
use dapple_camera::Film;
use dapple_math::PixelRect;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::Arc;

/// The state of a render at which every pixel has the same number of samples, or its share of it by the sample
/// allocation.
pub struct Snapshot<'a> {
    /// Samples per pixel so far, on average.
    pub spp: u32,
    /// Wall time of rendering so far, in seconds.
    pub seconds: f64,
    pub(super) rect: PixelRect,
    pub(super) tiles: &'a [Tile],
    /// The sample allocation, if the pixels have different sample counts.
    pub allocation: Option<&'a Arc<SampleAllocation>>,
    /// Whether the snapshot was requested between two regular ones.
    pub between: bool,
    pub(super) asked: Cell<Option<u32>>,
}

/// Called at every snapshot; may stop the render.
pub type Look<'a> = dyn FnMut(&Snapshot<'_>) -> ControlFlow<()> + 'a;

impl<'a> Snapshot<'a> {
    pub(super) fn new(
        spp: u32,
        seconds: f64,
        rect: PixelRect,
        tiles: &'a [Tile],
        allocation: Option<&'a Arc<SampleAllocation>>,
    ) -> Self {
        Self { spp, seconds, rect, tiles, allocation, between: false, asked: Cell::new(None) }
    }
    /// The snapshot, as one that was requested between two regular ones or not.
    pub fn as_between(self, between: bool) -> Self {
        Self { between, ..self }
    }

    /// Means and variances so far.
    pub fn film(&self) -> Film {
        let mut film = Film::new(self.rect);
        self.tiles.iter().for_each(|tile| film.put(&tile.film));
        film
    }

    /// The largest differences of neighbouring samples so far.
    pub fn tail(&self) -> Tail {
        tail(self.tiles)
    }

    /// Requests an additional snapshot at `spp` samples, rounded up to whole rounds; a further request replaces this
    /// one.
    pub fn also_at(&self, spp: u32) {
        self.asked.set(Some(spp));
    }

    /// Number of rays traced so far.
    pub fn rays(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.rays).sum()
    }
}

/// The largest differences of all tiles.
pub(super) fn tail(tiles: &[Tile]) -> Tail {
    let mut all = Tail::default();
    tiles.iter().for_each(|tile| all.merge(&tile.tail));
    all
}

/// The sample count of the next regular snapshot after `spp`.
pub(super) fn next(settings: &Settings, spp: u32) -> u32 {
    let round = settings.round();
    let start = settings.sample_range().start;
    match settings.samples().map(|end| end - start) {
        Some(n) => (0..32).rev().map(|k| n >> k).find(|m| *m > spp && m % round == 0).unwrap_or(n),
        None => (spp / round + 1).checked_next_power_of_two().unwrap_or(u32::MAX).saturating_mul(round),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MethodKind;
    use std::time::Duration;

    fn all(settings: &Settings, most: usize) -> Vec<u32> {
        let mut counts = vec![next(settings, 0)];
        while counts.len() < most && counts.last() != settings.samples().as_ref() {
            counts.push(next(settings, counts[counts.len() - 1]));
        }
        counts
    }

    #[test]
    fn counts_double_and_end_at_the_last() {
        let path = |spp| Settings::default().with_time_limit(Duration::from_secs(1)).with_spp(spp);
        assert_eq!(all(&path(Some(16)), 9), [1, 2, 4, 8, 16]);
        assert_eq!(all(&path(Some(100)), 9), [1, 3, 6, 12, 25, 50, 100]);
        assert_eq!(all(&path(None), 5), [1, 2, 4, 8, 16]);
        let distribution = |time_limit| {
            Settings::default().with_method(MethodKind::Distribution).with_time_limit(time_limit)
        };
        assert_eq!(all(&distribution(None), 9), [16]);
        assert_eq!(all(&distribution(Some(Duration::from_secs(1))), 3), [16, 32, 64]);
    }
}
