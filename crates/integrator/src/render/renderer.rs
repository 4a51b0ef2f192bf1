//! Stepwise rendering: start, advance, take snapshots, save and resume, finish.

use super::layers;
use super::outcome::{Outcome, Progress, Stats};
use super::part::Part;
use super::pilot::{Pilot, PilotResult};
use super::pool::Pool;
use super::snapshot::{self, Snapshot};
use super::watch::Watch;
use crate::batch::Batches;
use crate::bias_report::{BiasReport, BiasTotals};
use crate::custom::Integrator;
use crate::facts::Facts;
use crate::job::Job;
use crate::kernel::{self, Kernel};
use crate::settings::{Settings, SettingsError};
use crate::tile::Tile;
use dapple_camera::{Camera, Film};
use dapple_math::PixelRect;
use dapple_scene::Scene;
use std::any::Any;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

/// Maximum number of bad samples reported individually.
const REPORTED: usize = 16;

/// A render in progress. [`advance`](Self::advance) adds samples; between two calls all pixels have the same number of
/// samples, or their share of it by the sample allocation. The division of the samples into calls changes no bit of the
/// image.
pub struct Renderer<'a> {
    job: Job<'a>,
    kernel: Kernel<'a>,
    kernel_name: &'static str,
    batches: Option<Batches>,
    pool: Pool,
    state: RenderState,
}

/// The sums of a render so far. A [`Renderer`] that resumes from this state produces the same bytes. With the feature
/// `serde` it can be stored.
#[derive(Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RenderState {
    /// The settings of the render, without those that change no bit.
    belongs_to: String,
    /// Index of the first sample of every pixel.
    first: u32,
    /// Index of the next sample of every pixel.
    next: u32,
    tiles: Vec<Tile>,
    pilot: Pilot,
    elapsed: Duration,
}

impl RenderState {
    /// Index of the next sample of every pixel.
    pub fn next_sample(&self) -> u32 {
        self.next
    }

    /// Time spent on the render so far.
    pub fn elapsed(&self) -> Duration {
        self.elapsed
    }

    /// Whether this can be the state of the render that `fresh` is the start of.
    fn fits(&self, fresh: &Self, rect: PixelRect) -> bool {
        let tiles = || self.tiles.iter().zip(&fresh.tiles);
        self.belongs_to == fresh.belongs_to
            && self.first == fresh.first
            && self.next >= fresh.next
            && self.pilot.is_like(&fresh.pilot, rect)
            && self.tiles.len() == fresh.tiles.len()
            && tiles().all(|(tile, fresh)| tile.is_like(fresh, self.next))
    }
}

/// Why [`Renderer::advance`] returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Advance {
    /// Every pixel has the requested samples, or all samples of the settings.
    Reached,
    /// `progress` stopped the render.
    Stopped,
    /// There is no time for a further round.
    TimedOut,
}

impl<'a> Renderer<'a> {
    /// Creates a render; no sample is taken yet.
    pub fn new(scene: &'a Scene, camera: &Camera, settings: &'a Settings) -> Result<Self, SettingsError> {
        settings.check()?;
        Ok(Self::unchecked(scene, camera, settings))
    }

    /// As [`new`](Self::new), with a custom integrator in place of [`Settings::method`]: tiles, samples, camera rays,
    /// filter and film are the same, but `integrator` computes the radiance of each camera ray.
    pub fn with_integrator(
        scene: &'a Scene,
        camera: &Camera,
        settings: &'a Settings,
        integrator: &'a dyn Integrator,
    ) -> Result<Self, SettingsError> {
        settings.check()?;
        Ok(Self::of(Job::new(scene, camera, settings), (Kernel::Custom(integrator), "custom")))
    }

    /// Resumes a render from `state`.
    pub fn resume(
        scene: &'a Scene,
        camera: &Camera,
        settings: &'a Settings,
        state: RenderState,
    ) -> Result<Self, SettingsError> {
        let mut renderer = Self::new(scene, camera, settings)?;
        if !state.fits(&renderer.state, settings.rect()) {
            return Err(SettingsError::OtherRender);
        }
        renderer.state = state;
        Ok(renderer)
    }

    pub(super) fn unchecked(scene: &'a Scene, camera: &Camera, settings: &'a Settings) -> Self {
        let job = Job::new(scene, camera, settings);
        let kernel = kernel::choose(&job);
        Self::of(job, kernel)
    }

    fn of(job: Job<'a>, (kernel, kernel_name): (Kernel<'a>, &'static str)) -> Self {
        let settings = job.settings;
        let mut tiles = Tile::cut(settings.rect(), settings);
        let pilot = Pilot::new(settings, &mut tiles);
        let (belongs_to, first) = (settings.identity(), settings.sample_range().start);
        let state = RenderState { belongs_to, first, next: first, tiles, pilot, elapsed: Duration::ZERO };
        let batches = Batches::new(&job, kernel);
        Self { pool: Pool::new(&settings.limits), job, kernel, kernel_name, batches, state }
    }

    /// Adds samples until every pixel has those below index `until`, rounded up to whole rounds of the distribution
    /// tracer, all samples are taken, time is up, or `progress` returns `Break`. `progress` is called about every 50
    /// ms, on a separate thread; the samples of an interrupted pass are discarded, unless it is the first.
    pub fn advance(
        &mut self,
        until: u32,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Advance {
        self.advance_between(until, progress, &mut |_| {})
    }

    /// As [`advance`](Self::advance); calls `between` after each complete pass, that is about once per second. Its time
    /// counts as rendering.
    pub fn advance_between(
        &mut self,
        until: u32,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
        between: &mut dyn FnMut(&Self),
    ) -> Advance {
        let watch = Watch::new(self.job.settings, self.state.elapsed, self.state.next, progress);
        self.job.stop = watch.stop.clone();
        let range = self.job.settings.sample_range();
        let wanted = until.clamp(range.start, range.end) - range.start;
        let whole = wanted.checked_next_multiple_of(self.job.settings.round()).unwrap_or(u32::MAX);
        let until = range.start.saturating_add(whole).min(range.end);
        let reached = watch.during(|| {
            loop {
                if self.state.next >= until {
                    return true;
                }
                let is_whole = self.pass(until, &watch);
                self.state.elapsed = watch.elapsed();
                if !is_whole {
                    return false;
                }
                between(self);
            }
        });
        self.state.elapsed = watch.elapsed();
        match reached {
            _ if self.is_complete() => Advance::Reached,
            true => Advance::Reached,
            false if watch.is_cancelled() => Advance::Stopped,
            false => Advance::TimedOut,
        }
    }

    /// Runs one pass, not beyond the index `until`; returns whether it is complete.
    fn pass(&mut self, until: u32, watch: &Watch<'_>) -> bool {
        let (job, kernel, state) = (&self.job, (self.kernel, self.batches.as_ref()), &mut self.state);
        let start = job.settings.sample_range().start;
        let from = state.next;
        let Some(end) = watch.next_pass(from) else { return false };
        let end = end.min(until).min(state.pilot.next(from));
        let allocation = state.pilot.allocation.clone();
        self.pool.each_tile(&mut state.tiles, |tile| {
            if watch.is_stopped() {
                return;
            }
            if tile.failure.is_some() {
                tile.next = end;
                return;
            }
            tile.begin(from > start, job.settings);
            let before = tile.rays;
            let render = || tile.render(job, kernel, (from, end), allocation.as_deref());
            match catch_unwind(AssertUnwindSafe(render)) {
                Ok(samples) => watch.tile_done(samples, tile.rays - before),
                Err(panic) => {
                    tile.fail(message(&*panic), job.settings);
                    tile.next = end;
                }
            }
        });
        if state.tiles.iter().any(|tile| tile.next != end) {
            state.tiles.iter_mut().for_each(Tile::take_back);
            return false;
        }
        self.pool.each_tile(&mut state.tiles, Tile::keep);
        state.next = end;
        state.pilot.record(end, job.settings.rect(), &state.tiles);
        true
    }

    pub(super) fn settings(&self) -> &Settings {
        self.job.settings
    }

    /// Samples per pixel so far; with a sample allocation, the average.
    pub fn spp(&self) -> u32 {
        self.state.next - self.job.settings.sample_range().start
    }

    /// Whether every pixel has all samples of the settings.
    pub fn is_complete(&self) -> bool {
        self.state.next >= self.job.settings.sample_range().end
    }

    /// The current image. A snapshot changes no bit of the render.
    pub fn snapshot(&self) -> Snapshot<'_> {
        Snapshot::new(
            self.spp(),
            self.state.elapsed.as_secs_f64(),
            self.job.settings.rect(),
            &self.state.tiles,
            self.state.pilot.allocation.as_ref(),
        )
    }

    /// What the pilot samples decide, as far as they are taken.
    pub fn pilot(&self) -> PilotResult {
        let Pilot { variance, allocation, .. } = &self.state.pilot;
        PilotResult { variance: variance.clone(), allocation: allocation.clone() }
    }

    /// All sums so far, to be stored.
    pub fn saved(&self) -> &RenderState {
        &self.state
    }

    /// A copy of all sums so far, for [`Renderer::resume`].
    pub fn state(&self) -> RenderState {
        self.state.clone()
    }

    /// As [`finish_as`](Self::finish_as); also returns the samples as a part of a larger render.
    pub fn finish_with_part(self, why: Advance) -> (Outcome, Option<Part>) {
        (self.outcome(why), self.finish_part())
    }

    /// Ends the render with its current samples as a part of a larger one; none if not every pixel has a sample.
    pub fn finish_part(self) -> Option<Part> {
        let facts = Facts::of(&self.job);
        let RenderState { belongs_to, first, next, tiles, elapsed, .. } = self.state;
        Part::new(&belongs_to, facts, (self.job.settings.rect(), first..next), tiles, elapsed)
    }

    /// Ends the render with its current samples.
    pub fn finish(self) -> Outcome {
        self.finish_as(Advance::Reached)
    }

    /// Ends the render with its current samples; `why` is the result of the last advance.
    pub fn finish_as(mut self, why: Advance) -> Outcome {
        let mut film = Film::new(self.job.settings.rect());
        self.state.tiles.iter_mut().for_each(|tile| film.put(&tile.take_film()));
        self.outcome_of(film, why)
    }

    /// The image and statistics of the current samples; `why` is the result of the last advance, or why the render
    /// would end now. It changes no bit of the render.
    pub fn outcome(&self, why: Advance) -> Outcome {
        self.outcome_of(self.snapshot().film(), why)
    }

    fn outcome_of(&self, film: Film, why: Advance) -> Outcome {
        let Self { job, state, pool, .. } = self;
        let spp = state.next - job.settings.sample_range().start;
        let mut stats = Stats {
            seconds: state.elapsed.as_secs_f64(),
            spp,
            stopped: why == Advance::Stopped,
            timed_out: why == Advance::TimedOut,
            threads: pool.threads(),
            kernel: format!("{}/{}", self.kernel_name, job.scene.accel.kernel().name()),
            ..Stats::default()
        };
        let mut bias = BiasTotals::default();
        for tile in &state.tiles {
            stats.rays += tile.rays;
            stats.bad_sample_count += tile.bad_count;
            bias.merge(&tile.bias);
            stats.failures.extend(tile.failure.iter().map(|failure| (tile.rect, failure.clone())));
            let room = REPORTED - stats.bad_samples.len();
            stats.bad_samples.extend(tile.bad.iter().take(room));
        }
        stats.samples = film.samples();
        let facts = Facts::of(job);
        stats.bias = BiasReport {
            lights_culled: facts.lights_culled,
            lights_unreachable: facts.lights_unreachable,
            ..bias.report()
        };
        let layers = layers::compose(&facts, job.settings.rect(), &film, &state.tiles, spp == 0);
        let tail = snapshot::tail(&state.tiles);
        let pilot = state.pilot.variance.clone();
        Outcome { film, layers, stats, allocation: state.pilot.allocation.clone(), tail, pilot }
    }
}

/// Message of a panic.
fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into())
}
