//! Parts of a render: the sums of some samples of some pixels. Merged parts have the bits of one render of all of them.

use super::layers;
use super::outcome::{Outcome, Stats};
use super::snapshot;
use crate::bias_report::BiasReport;
use crate::facts::Facts;
use crate::settings::Settings;
use crate::tile::Tile;
use dapple_camera::{Film, FilmMismatch};
use dapple_math::PixelRect;
use std::ops::Range;
use std::time::Duration;

/// Samples that a part has: those with indices in `samples` of every pixel of `rect`. With a sample allocation the
/// indices are those of a pixel with the mean number of samples.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Covered {
    /// The pixels.
    pub rect: PixelRect,
    /// Indices of the samples of each pixel.
    pub samples: Range<u32>,
}

/// Sums of a part of a render. With the feature `serde` it can be stored.
///
/// Its size is that of the film, 8 bytes per pixel and 48 for each node of the tree over the samples
/// ([`dapple_camera::sums`]), and of the requested layers.
#[derive(Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Part {
    /// The settings of the render, without those in which parts may differ.
    belongs_to: String,
    facts: Facts,
    covered: Vec<Covered>,
    /// Films of the rectangle of `sums`. There are several if some samples between them are missing.
    films: Vec<Film>,
    /// All other sums.
    sums: Tile,
    elapsed: Duration,
}

/// Why parts are not merged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PartError {
    /// The parts belong to renders of other scenes or with other settings.
    #[error("the parts belong to renders with different settings or scenes")]
    Other,
    /// The parts have a sample in common.
    #[error("both have samples {samples:?} of the pixels {x0},{y0} to {x1},{y1}", samples = .0.samples, x0 = .0.rect.x0, y0 = .0.rect.y0, x1 = .0.rect.x1, y1 = .0.rect.y1)]
    Overlap(Covered),
    /// The sums of the part contradict each other, as in a file that was damaged.
    #[error("its sums contradict each other")]
    Damaged,
}

impl Part {
    /// The part that a render has finished: `tiles` with the samples `samples`; none without a sample.
    pub(super) fn new(
        belongs_to: &str,
        facts: Facts,
        (rect, samples): (PixelRect, Range<u32>),
        tiles: Vec<Tile>,
        elapsed: Duration,
    ) -> Option<Self> {
        let mut sums = tiles.first()?.like(rect);
        let mut film = Film::new(rect);
        let is_whole = tiles.iter().all(|tile| tile.failure.is_none());
        let mut covered: Vec<Covered> = Vec::new();
        if is_whole {
            covered.push(Covered { rect, samples: samples.clone() });
        }
        for mut tile in tiles {
            if tile.failure.is_some() {
                continue;
            }
            film.put(&tile.take_film());
            sums.merge_sums(&tile);
            if !is_whole {
                covered.push(Covered { rect: tile.rect, samples: samples.clone() });
            }
        }
        let has_samples = !samples.is_empty() && !covered.is_empty();
        has_samples.then(|| Self {
            belongs_to: belongs_to.to_string(),
            facts,
            covered,
            films: vec![film],
            sums,
            elapsed,
        })
    }

    /// The samples that this part has.
    pub fn covered(&self) -> &[Covered] {
        &self.covered
    }

    /// The rectangle that contains all pixels of the part.
    pub fn rect(&self) -> PixelRect {
        self.sums.rect
    }

    /// Size of the full image in pixels.
    pub fn size(&self) -> (u32, u32) {
        self.facts.size
    }

    /// Time that rendering the part took.
    pub fn elapsed(&self) -> Duration {
        self.elapsed
    }

    /// Checks the sums of a part that was read from a file.
    ///
    /// # Errors
    /// [`PartError::Damaged`] if they contradict each other.
    pub fn check(&self) -> Result<(), PartError> {
        let rect = self.sums.rect;
        let is_inside = |part: &PixelRect| {
            part.x0 < part.x1
                && part.y0 < part.y1
                && part.x1 <= self.facts.size.0
                && part.y1 <= self.facts.size.1
        };
        let is_sound = is_inside(&rect)
            && self.sums.is_sums()
            && self.has_layers()
            && !self.covered.is_empty()
            && self.covered.iter().all(|c| is_inside(&c.rect) && c.rect.intersection(&rect) == c.rect)
            && self.covered.iter().all(|c| !c.samples.is_empty())
            && !self.films.is_empty()
            && self.films.iter().all(|film| film.rect() == rect && film.is_whole());
        if is_sound { Ok(()) } else { Err(PartError::Damaged) }
    }

    /// Whether the sums are those of the requested layers.
    fn has_layers(&self) -> bool {
        let (aovs, transparent) = (self.facts.aovs.clone(), self.facts.transparent);
        let asked = Settings { aovs, transparent, ..Settings::default() };
        let pixel = PixelRect { x0: 0, y0: 0, x1: 1, y1: 1 };
        Tile::cut(pixel, &asked).iter().all(|tile| self.sums.is_of_layers(tile))
    }

    /// Adds the samples of `other`, of which this part has none.
    ///
    /// # Errors
    /// The parts belong to different renders, or have samples in common; this part is unchanged.
    pub fn merge(&mut self, other: Self) -> Result<(), PartError> {
        if self.belongs_to != other.belongs_to || self.facts != other.facts {
            return Err(PartError::Other);
        }
        if !self.sums.is_of_layers(&other.sums) {
            return Err(PartError::Damaged);
        }
        if let Some(both) = overlap(&self.covered, &other.covered) {
            return Err(PartError::Overlap(both));
        }
        let rect = around(self.sums.rect, other.sums.rect);
        self.widen(rect);
        self.sums.merge_sums(&other.sums);
        for film in other.films {
            let film = widened(film, rect);
            let tail = &mut self.sums.tail;
            let mut adjoins =
                |mine: &mut Film| mine.merge_measured(&film, |squared| tail.add(squared)).is_ok();
            if !self.films.iter_mut().any(&mut adjoins) {
                self.films.push(film);
            }
        }
        self.covered.extend(other.covered);
        self.elapsed += other.elapsed;
        self.join();
        Ok(())
    }

    /// Extends the sums to `rect`, which contains all pixels of the part.
    fn widen(&mut self, rect: PixelRect) {
        if rect == self.sums.rect {
            return;
        }
        let mut wide = self.sums.like(rect);
        wide.merge_sums(&self.sums);
        self.sums = wide;
        self.films = std::mem::take(&mut self.films).into_iter().map(|film| widened(film, rect)).collect();
    }

    /// Merges films of which one begins where another ends.
    fn join(&mut self) {
        let mut at = 1;
        while at < self.films.len() {
            let film = self.films.swap_remove(at);
            let tail = &mut self.sums.tail;
            let mut adjoins =
                |mine: &mut Film| mine.merge_measured(&film, |squared| tail.add(squared)).is_ok();
            if self.films[..at].iter_mut().any(&mut adjoins) {
                at = 1;
            } else {
                self.films.insert(at, film);
                at += 1;
            }
        }
    }

    /// The image of all samples, and its statistics. `spp` is their number per pixel, or on average.
    ///
    /// # Errors
    /// [`PartError::Damaged`] if the sums contradict each other.
    pub fn outcome(&self, spp: u32) -> Result<Outcome, PartError> {
        let rect = self.sums.rect;
        let film = match &self.films[..] {
            [film] => film.clone(),
            films => Film::united(films).map_err(|_: FilmMismatch| PartError::Damaged)?,
        };
        let tiles = std::slice::from_ref(&self.sums);
        let stats = Stats {
            seconds: self.elapsed.as_secs_f64(),
            spp,
            samples: film.samples(),
            rays: self.sums.rays,
            bad_samples: self.sums.bad.clone(),
            bad_sample_count: self.sums.bad_count,
            bias: BiasReport {
                lights_culled: self.facts.lights_culled,
                lights_unreachable: self.facts.lights_unreachable,
                ..self.sums.bias.report()
            },
            ..Stats::default()
        };
        let layers = layers::compose(&self.facts, rect, &film, tiles, spp == 0);
        let tail = snapshot::tail(tiles);
        Ok(Outcome { film, layers, stats, allocation: None, tail, pilot: None })
    }
}

/// The smallest rectangle that contains both.
fn around(a: PixelRect, b: PixelRect) -> PixelRect {
    PixelRect { x0: a.x0.min(b.x0), y0: a.y0.min(b.y0), x1: a.x1.max(b.x1), y1: a.y1.max(b.y1) }
}

/// The film with further pixels, which have no samples.
fn widened(film: Film, rect: PixelRect) -> Film {
    if film.rect() == rect {
        return film;
    }
    let mut wide = Film::new(rect);
    wide.put(&film);
    wide
}

/// Some samples that both have.
fn overlap(ours: &[Covered], theirs: &[Covered]) -> Option<Covered> {
    let both = |a: &Covered, b: &Covered| {
        let rect = a.rect.intersection(&b.rect);
        let samples = a.samples.start.max(b.samples.start)..a.samples.end.min(b.samples.end);
        (rect.area() > 0 && !samples.is_empty()).then_some(Covered { rect, samples })
    };
    ours.iter().find_map(|ours| theirs.iter().find_map(|theirs| both(ours, theirs)))
}

/// The samples with indices in `wanted` of the pixels of `rect` that `covered` lacks, at most one entry per rectangle of pixels that
/// lack the same samples, and in the order of the samples.
pub fn missing(covered: &[Covered], rect: PixelRect, wanted: Range<u32>) -> Vec<Covered> {
    let Range { start, end } = wanted;
    let edges = |of: &dyn Fn(&PixelRect) -> [u32; 2], all: [u32; 2]| {
        let mut edges: Vec<u32> = covered.iter().flat_map(|c| of(&c.rect)).chain(all).collect();
        edges.retain(|edge| (all[0]..=all[1]).contains(edge));
        edges.sort_unstable();
        edges.dedup();
        edges
    };
    let xs = edges(&|r| [r.x0, r.x1], [rect.x0, rect.x1]);
    let ys = edges(&|r| [r.y0, r.y1], [rect.y0, rect.y1]);
    let mut sorted: Vec<&Covered> = covered.iter().collect();
    sorted.sort_by_key(|c| c.samples.start);
    let mut all: Vec<Covered> = Vec::new();
    for y in ys.windows(2) {
        for x in xs.windows(2) {
            let cell = PixelRect { x0: x[0], y0: y[0], x1: x[1], y1: y[1] };
            let mut next = start;
            let mut lacks = |samples: Range<u32>| {
                let beside = all.iter_mut().find(|c| {
                    c.samples == samples && (c.rect.y0, c.rect.y1, c.rect.x1) == (cell.y0, cell.y1, cell.x0)
                });
                match beside {
                    Some(left) => left.rect.x1 = cell.x1,
                    None => all.push(Covered { rect: cell, samples }),
                }
            };
            for part in sorted.iter().filter(|part| part.rect.intersection(&cell) == cell) {
                if part.samples.start > next {
                    lacks(next..part.samples.start.min(end));
                }
                next = next.max(part.samples.end);
                if next >= end {
                    break;
                }
            }
            if next < end {
                lacks(next..end);
            }
        }
    }
    all.retain(|c| !c.samples.is_empty());
    all.sort_by_key(|c| (c.samples.start, c.rect.y0, c.rect.x0));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covered(x: Range<u32>, samples: Range<u32>) -> Covered {
        Covered { rect: PixelRect { x0: x.start, y0: 0, x1: x.end, y1: 4 }, samples }
    }

    #[test]
    fn missing_samples_are_found() {
        let rect = PixelRect { x0: 0, y0: 0, x1: 8, y1: 4 };
        let lacks = |all: &[Covered]| missing(all, rect, 0..100);
        assert_eq!(lacks(&[]), [covered(0..8, 0..100)]);
        assert!(lacks(&[covered(0..8, 7..100), covered(0..8, 0..7)]).is_empty());
        assert!(lacks(&[covered(0..3, 0..100), covered(3..8, 0..50), covered(3..8, 50..200)]).is_empty());
        let holes = [covered(0..3, 0..100), covered(3..5, 9..60), covered(5..8, 9..60)];
        assert_eq!(lacks(&holes), [covered(3..8, 0..9), covered(3..8, 60..100)]);
        assert_eq!(lacks(&[covered(0..8, 0..7), covered(0..8, 9..100)]), [covered(0..8, 7..9)]);
        assert!(missing(&holes, PixelRect { x0: 3, ..rect }, 9..60).is_empty());
    }

    #[test]
    fn common_samples_are_found() {
        let a = [covered(0..3, 0..10), covered(3..8, 0..20)];
        assert_eq!(overlap(&a, &[covered(0..8, 10..20)]), Some(covered(3..8, 10..20)));
        assert_eq!(overlap(&a, &[covered(0..3, 10..20), covered(8..9, 0..9)]), None);
    }
}
