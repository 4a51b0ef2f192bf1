//! Film tiles: the pixels that one worker renders, with the requested layers.

use crate::allocation::SampleAllocation;
use crate::aov::Aov;
use crate::batch::{Batch, Batches, Done};
use crate::bias_report::{BiasReport, BiasTotals, Removed};
use crate::first_hit_sums::{FirstHit, FirstHits};
use crate::job::Job;
use crate::kernel::Kernel;
use crate::settings::Settings;
use crate::tail::Tail;
use dapple_camera::Film;
use dapple_math::PixelRect;
use glam::Vec3;

/// Side of a tile in pixels.
const SIDE: u32 = 16;

/// Maximum number of bad samples recorded individually per tile; all are counted.
const REMEMBERED: usize = 4;

/// A sample that was not finite; `dapple replay --pixel x,y --sample i` shows its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BadSample {
    /// Pixel column.
    pub x: u32,
    /// Pixel row from the top.
    pub y: u32,
    /// Sample index.
    pub sample: u32,
}

/// A tile: pixels, their sums, and their errors.
#[derive(Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Tile {
    pub rect: PixelRect,
    /// Index of the next sample of every pixel.
    pub next: u32,
    /// The sums of all passes before the one in progress, which has its own, unless it is the first.
    #[cfg_attr(feature = "serde", serde(skip))]
    before: Option<Box<Tile>>,
    /// Has no pixels before a pass, so that a render that is stopped at once does not allocate it.
    pub film: Film,
    pub first_hits: FirstHits,
    /// For each pixel, what the bias report contains; empty unless requested.
    pub removed: Vec<Removed>,
    pub rays: u64,
    /// Rays per pixel, for adaptive sampling; otherwise empty.
    pub pixel_rays: Vec<u64>,
    pub bad: Vec<BadSample>,
    pub bad_count: u64,
    pub bias: BiasTotals,
    pub tail: Tail,
    /// Message of the panic that ended the tile; its pixels have no samples.
    pub failure: Option<String>,
}

impl Tile {
    /// Divides `rect` into tiles, row by row.
    pub fn cut(rect: PixelRect, settings: &Settings) -> Vec<Self> {
        let rows = (rect.y0..rect.y1).step_by(SIDE as usize);
        rows.flat_map(|y0| {
            (rect.x0..rect.x1).step_by(SIDE as usize).map(move |x0| {
                let part = PixelRect { x0, y0, x1: (x0 + SIDE).min(rect.x1), y1: (y0 + SIDE).min(rect.y1) };
                Self::new(part, settings)
            })
        })
        .collect()
    }

    fn new(rect: PixelRect, settings: &Settings) -> Self {
        let has_removed = settings.aovs.contains(&Aov::Removed);
        let first_hits = FirstHits::new(rect.area(), settings);
        Self::empty(rect, settings.sample_range().start, (first_hits, has_removed))
    }

    /// A tile without samples, whose next sample has the index `next`.
    fn empty(rect: PixelRect, next: u32, (first_hits, has_removed): (FirstHits, bool)) -> Self {
        Self {
            rect,
            next,
            before: None,
            film: Film::new(none(rect)),
            first_hits,
            removed: vec![Removed::default(); if has_removed { rect.area() } else { 0 }],
            rays: 0,
            pixel_rays: Vec::new(),
            bad: Vec::new(),
            bad_count: 0,
            bias: BiasTotals::default(),
            tail: Tail::default(),
            failure: None,
        }
    }

    /// Whether this can be the state before sample `next` of the tile that `fresh` is the start of. The samples of an
    /// incomplete first pass are discarded.
    pub fn is_like(&self, fresh: &Self, next: u32) -> bool {
        let has_samples = next > fresh.next;
        self.rect == fresh.rect
            && (!has_samples || self.failure.is_some() || self.next == next)
            && (!has_samples || self.film.rect() == self.rect)
            && [self.rect, none(self.rect)].contains(&self.film.rect())
            && self.film.is_whole()
            && self.removed.len() == fresh.removed.len()
            && self.pixel_rays.len() == fresh.pixel_rays.len()
            && self.first_hits.is_like(&fresh.first_hits)
    }

    /// Prepares for a pass that may be interrupted: a further pass (`has_samples`) is summed apart, so that it can be
    /// rolled back. The samples of an interrupted first pass are discarded.
    pub fn begin(&mut self, has_samples: bool, settings: &Settings) {
        let pixel_rays = vec![0; self.pixel_rays.len()];
        let new = Self { next: self.next, pixel_rays, ..Self::new(self.rect, settings) };
        let before = std::mem::replace(self, new);
        if has_samples {
            self.before = Some(Box::new(before));
        } else {
            self.next = settings.sample_range().start;
        }
    }

    /// Commits the pass after all tiles have finished it.
    pub fn keep(&mut self) {
        if let Some(before) = self.before.take() {
            let pass = std::mem::replace(self, *before);
            self.merge(pass);
        } else {
            self.film.trim();
        }
    }

    /// Adds the sums of a pass.
    fn merge(&mut self, pass: Self) {
        self.next = pass.next;
        self.merge_totals(&pass);
        let tail = &mut self.tail;
        // The pass begins where these sums end, in the same pixels.
        let adjoins = self.film.merge_measured(&pass.film, |squared| tail.add(squared));
        debug_assert_eq!(adjoins, Ok(()));
        self.first_hits.merge(&pass.first_hits);
        self.removed.iter_mut().zip(&pass.removed).for_each(|(sum, other)| sum.merge(other));
        self.pixel_rays.iter_mut().zip(&pass.pixel_rays).for_each(|(sum, rays)| *sum += rays);
    }

    /// Empty sums of the same layers for the pixels of `rect`, without a film.
    pub fn like(&self, rect: PixelRect) -> Self {
        Self::empty(rect, self.next, (self.first_hits.like(rect.area()), !self.removed.is_empty()))
    }

    /// Whether all sums have one entry per pixel, so that they can be merged; those read from a file may not.
    pub fn is_sums(&self) -> bool {
        let pixels = self.rect.area();
        [0, pixels].contains(&self.removed.len()) && self.first_hits.is_of(pixels)
    }

    /// Whether both have sums of the same layers.
    pub fn is_of_layers(&self, other: &Self) -> bool {
        let both = self.like(self.rect);
        let other = other.like(self.rect);
        both.removed.len() == other.removed.len() && both.first_hits.is_like(&other.first_hits)
    }

    /// Adds the sums of other samples, for pixels of this tile; the films are not touched.
    pub fn merge_sums(&mut self, other: &Self) {
        for (from, (x, y)) in pixels(other.rect).enumerate() {
            let to = self.pixel((x, y));
            self.first_hits.merge_pixel(to, &other.first_hits, from);
            if let (Some(sum), Some(other)) = (self.removed.get_mut(to), other.removed.get(from)) {
                sum.merge(other);
            }
        }
        self.merge_totals(other);
    }

    /// Adds the sums that are not those of a pixel.
    fn merge_totals(&mut self, other: &Self) {
        self.tail.merge(&other.tail);
        self.rays += other.rays;
        let room = REMEMBERED.saturating_sub(self.bad.len());
        self.bad.extend(other.bad.iter().take(room));
        self.bad_count += other.bad_count;
        self.bias.merge(&other.bias);
    }

    /// Ends the tile after a panic: its samples are discarded, and it takes part in no further pass.
    pub fn fail(&mut self, failure: String, settings: &Settings) {
        let pixel_rays = vec![0; self.pixel_rays.len()];
        let film = Film::new(self.rect);
        *self = Self { pixel_rays, film, failure: Some(failure), ..Self::new(self.rect, settings) };
    }

    /// Rolls the pass back because not all tiles have finished it, unless it is the first.
    pub fn take_back(&mut self) {
        if let Some(before) = self.before.take() {
            *self = *before;
        }
    }

    /// The film, which this tile no longer needs.
    pub fn take_film(&mut self) -> Film {
        std::mem::replace(&mut self.film, Film::new(none(self.rect)))
    }

    /// Adds samples `from..to` of every pixel, scaled by the sample allocation, until the job is stopped; returns how
    /// many.
    pub fn render(
        &mut self,
        job: &Job<'_>,
        (kernel, batches): (Kernel<'_>, Option<&Batches>),
        (from, to): (u32, u32),
        allocation: Option<&SampleAllocation>,
    ) -> u64 {
        let count = |x, y, spp| allocation.map_or(spp, |allocation| allocation.count(x, y, spp));
        if self.film.rect() != self.rect {
            self.film = Film::starting_at(self.rect, |x, y| count(x, y, from).into());
        }
        let asked = |x, y| (count(x, y, from), count(x, y, to));
        let (samples, is_done) = match batches {
            Some(batches) => self.in_batches(job, batches, asked),
            None => self.one_by_one(job, kernel, asked),
        };
        if is_done {
            self.next = to;
        }
        samples
    }

    /// Adds the samples that are `asked` of every pixel; returns how many, and whether that is all.
    fn one_by_one(
        &mut self,
        job: &Job<'_>,
        kernel: Kernel<'_>,
        asked: impl Fn(u32, u32) -> (u32, u32),
    ) -> (u64, bool) {
        let mut samples = 0;
        for (x, y) in pixels(self.rect) {
            let (from, to) = asked(x, y);
            for index in from..to {
                let (mut first, mut rays) = (self.first_hits.start(job.settings), 0);
                let (value, weight) = kernel.sample(job, (x, y), index, &mut first, &mut rays);
                self.count_rays(x, y, rays);
                if job.is_stopped() {
                    return (samples, false);
                }
                self.add(job, (x, y), index, (value, weight), &mut first);
                samples += 1;
            }
        }
        (samples, true)
    }

    /// As [`Self::one_by_one`].
    fn in_batches(
        &mut self,
        job: &Job<'_>,
        batches: &Batches,
        asked: impl Fn(u32, u32) -> (u32, u32),
    ) -> (u64, bool) {
        let (mut samples, mut batch) = (0, batches.take(job));
        for (x, y) in pixels(self.rect) {
            let (from, to) = asked(x, y);
            for index in from..to {
                if batch.add(job, (x, y), index) {
                    continue;
                }
                if !batches.trace(job, &mut batch) {
                    return (samples, false);
                }
                samples += self.add_batch(job, &mut batch);
                batch.add(job, (x, y), index);
            }
        }
        if !batches.trace(job, &mut batch) {
            return (samples, false);
        }
        samples += self.add_batch(job, &mut batch);
        batches.give(batch);
        (samples, true)
    }

    /// Adds the samples of a batch, and empties it; returns how many.
    fn add_batch(&mut self, job: &Job<'_>, batch: &mut Batch) -> u64 {
        for Done { pixel, index, value, weight, mut bias, first, rays } in batch.done() {
            self.count_rays(pixel.0, pixel.1, rays);
            self.add_value(job, pixel, index, (value, weight), &mut bias);
            if let Some(first) = first {
                self.first_hits.add(self.pixel(pixel), first, index, weight);
            }
        }
        let samples = batch.len() as u64;
        batch.clear();
        samples
    }

    fn count_rays(&mut self, x: u32, y: u32, rays: u64) {
        self.rays += rays;
        if !self.pixel_rays.is_empty() {
            let pixel = (y - self.rect.y0) * self.rect.width() + (x - self.rect.x0);
            self.pixel_rays[pixel as usize] += rays;
        }
    }

    /// Adds a sample.
    #[inline(always)]
    fn add(
        &mut self,
        job: &Job<'_>,
        pixel: (u32, u32),
        index: u32,
        (value, weight): (Vec3, f32),
        first: &mut FirstHit,
    ) {
        self.add_value(job, pixel, index, (value, weight), &mut first.bias);
        self.first_hits.add(self.pixel(pixel), first, index, weight);
    }

    /// Adds a sample without its first hit.
    #[inline(always)]
    fn add_value(
        &mut self,
        job: &Job<'_>,
        (x, y): (u32, u32),
        index: u32,
        (mut value, weight): (Vec3, f32),
        bias: &mut BiasReport,
    ) {
        if !job.settings.picture {
            // The image is not rendered, so that nothing was removed from it.
            (value, *bias) = (Vec3::ZERO, BiasReport::default());
        }
        if let Some(most) = job.settings.clamp.filter(|_| cfg!(not(without = "clamp"))) {
            value = bias.clamp(value, most);
        }
        if !bias.is_clean() {
            self.bias.add(bias);
        }
        let (finite, squared) = self.film.add_measured(x, y, value, weight);
        self.tail.add(squared);
        if !finite {
            self.bad_count += 1;
            if self.bad.len() < REMEMBERED {
                self.bad.push(BadSample { x, y, sample: index });
            }
        }
        let pixel = self.pixel((x, y));
        if let Some(removed) = self.removed.get_mut(pixel) {
            removed.add(bias, finite);
        }
    }

    /// Number of a pixel in the tile.
    #[inline(always)]
    fn pixel(&self, (x, y): (u32, u32)) -> usize {
        ((y - self.rect.y0) * (self.rect.x1 - self.rect.x0) + (x - self.rect.x0)) as usize
    }
}

/// A rectangle without pixels at the corner of another one.
fn none(rect: PixelRect) -> PixelRect {
    PixelRect { x1: rect.x0, y1: rect.y0, ..rect }
}

/// The pixels of a rectangle, row by row.
fn pixels(rect: PixelRect) -> impl Iterator<Item = (u32, u32)> {
    (rect.y0..rect.y1).flat_map(move |y| (rect.x0..rect.x1).map(move |x| (x, y)))
}
