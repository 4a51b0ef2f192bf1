//! The render loop: tiles, threads, passes, limits.
//!
//! A pass gives every pixel the same number of further samples. Passes start at one sample and grow to about two
//! seconds, so a render can stop at any time with every pixel equally sampled; how it is cut into passes, tiles and
//! threads changes no bit of the picture, for each pixel's samples are added in order.

use crate::kernel::{self, Job};
use crate::ledger::{self, Ledger};
use crate::settings::Settings;
use crate::spread::Spread;
use crate::tail::Tail;
use crate::tile::Tile;
use dapple_camera::{Camera, Film};
use dapple_imaging::Layers;
use dapple_scene::Scene;
use pilot::Pilot;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

mod checkpoint;
mod layers;
mod pilot;
mod pixels;

pub use checkpoint::{Checkpoint, Look};
pub use pixels::render_pixels;

/// How far a render is; told a few times a second.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Done, 0 to 1, by samples or by time, whichever is further.
    pub fraction: f64,
    /// Samples per pixel that all pixels have.
    pub spp: u32,
    /// Rays traced so far.
    pub rays: u64,
    /// Since rendering began.
    pub elapsed: Duration,
}

/// What a render took.
#[derive(Clone, Debug, Default)]
pub struct Stats {
    /// Wall time of rendering alone.
    pub seconds: f64,
    /// Camera samples.
    pub samples: u64,
    /// Rays: camera, scattered and shadow.
    pub rays: u64,
    /// Samples per pixel, on average.
    pub spp: u32,
    /// `progress` stopped the render before the samples or the time it was to take.
    pub stopped: bool,
    /// Worker threads.
    pub threads: usize,
    /// Sample kernel and traversal kernel.
    pub kernel: String,
    /// Places of the first samples that were not finite.
    pub bad_samples: Vec<BadSample>,
    /// How many samples were not finite. They add zero and still count.
    pub bad_sample_count: u64,
    /// What altered the estimate.
    pub ledger: Ledger,
}

/// A sample that was not finite; `dapple replay --pixel x,y --sample i` shows its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadSample {
    /// Pixel column.
    pub x: u32,
    /// Pixel row from the top.
    pub y: u32,
    /// Sample index.
    pub sample: u32,
}

/// A finished render.
#[derive(Debug)]
pub struct Outcome {
    /// Means and variances.
    pub film: Film,
    /// Beauty and the extra layers; metadata is for the caller to fill in.
    pub layers: Layers,
    /// What it took.
    pub stats: Stats,
    /// Which pixels got how many samples, where not all got the same.
    pub spread: Option<Arc<Spread>>,
    /// The samples that deviate most from their pixels.
    pub tail: Tail,
}

/// Most bad samples reported by place.
const REPORTED: usize = 16;

/// Renders. `progress` may stop the render by returning `Break`; the pass under way is finished first.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Outcome {
    run(scene, camera, settings, progress, None)
}

/// As [`render`], and shows the picture at growing sample counts: at n, n/2, n/4, … of the n samples asked for (rounded
/// down), or at 1, 2, 4, … where only time limits the render, and where [`Checkpoint::also_at`] asked for it; of the
/// distribution tracer whole pixels alone. Looking changes no bit of the picture, and its time is not counted as
/// rendering. `look` may say that it is enough; such a render counts as finished, not as stopped.
pub fn render_watched(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    look: &mut Look<'_>,
) -> Outcome {
    run(scene, camera, settings, progress, Some(look))
}

fn run(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    mut look: Option<&mut Look<'_>>,
) -> Outcome {
    let job = Job::new(scene, camera, settings);
    let (kernel, name) = kernel::choose(&job);
    let mut tiles = Tile::cut(settings.rect(), settings);
    let threads = thread_count(settings);
    let watch = Watch::new(settings, progress);
    let mut pilot = Pilot::new(settings, &mut tiles);
    let mut spp = 0;
    let (mut looking, mut asked) = (Duration::ZERO, None);
    while let Some(mut end) = watch.next_pass(spp) {
        let regular = checkpoint::next(settings, spp);
        let stop_at = asked.filter(|n| *n > spp && *n < regular).unwrap_or(regular);
        if look.is_some() {
            end = end.min(stop_at);
        }
        end = end.min(pilot.next(spp));
        let spread = pilot.spread.clone();
        each_tile(threads, &mut tiles, |tile| {
            let before = tile.rays;
            let samples = tile.render(&job, kernel, (spp, end), spread.as_deref());
            watch.tile_done(samples, tile.rays - before, spp);
        });
        spp = end;
        pilot.take(spp, settings.rect(), &tiles);
        if let Some(look) = look.as_mut().filter(|_| spp == stop_at) {
            let now = Instant::now();
            let seconds = (now - watch.start - looking).as_secs_f64();
            let at = Checkpoint {
                spp,
                seconds,
                rect: settings.rect(),
                tiles: &tiles,
                spread: pilot.spread.as_ref(),
                between: spp != regular,
                asked: Cell::new(asked),
            };
            let enough = look(&at).is_break();
            asked = at.asked.get().and_then(|n| n.checked_next_multiple_of(settings.round()));
            looking += now.elapsed();
            if enough {
                break;
            }
        }
    }
    let seconds = (watch.start.elapsed() - looking).as_secs_f64();
    let kernel = format!("{name}/{}", scene.world.kernel().name());
    let stopped = watch.stopped(spp);
    let ledger = Ledger { lights_culled: ledger::culled(scene), ..Ledger::default() };
    let stats = Stats { seconds, spp, stopped, threads, kernel, ledger, ..Stats::default() };
    finish(&job, tiles, stats, pilot.spread)
}

fn finish(job: &Job<'_>, tiles: Vec<Tile>, mut stats: Stats, spread: Option<Arc<Spread>>) -> Outcome {
    let mut film = Film::new(job.settings.rect());
    for tile in &tiles {
        film.put(&tile.film);
        stats.rays += tile.rays;
        stats.bad_sample_count += tile.bad_count;
        stats.ledger.merge(&tile.ledger);
        let room = REPORTED - stats.bad_samples.len();
        stats.bad_samples.extend(tile.bad.iter().take(room));
    }
    stats.samples = film.samples();
    let layers = layers::compose(job, &film, &tiles);
    Outcome { film, layers, stats, spread, tail: checkpoint::tail(&tiles) }
}

/// Decides how long each pass is, when to stop, and tells how far things are.
struct Watch<'a> {
    start: Instant,
    settings: &'a Settings,
    progress: &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync),
    pixels: u64,
    samples: AtomicU64,
    rays: AtomicU64,
    told_ms: AtomicU64,
    stop: AtomicBool,
}

impl<'a> Watch<'a> {
    fn new(settings: &'a Settings, progress: &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync)) -> Self {
        let rect = settings.rect();
        Self {
            start: Instant::now(),
            settings,
            progress,
            pixels: u64::from(rect.x1 - rect.x0) * u64::from(rect.y1 - rect.y0),
            samples: AtomicU64::new(0),
            rays: AtomicU64::new(0),
            told_ms: AtomicU64::new(0),
            stop: AtomicBool::new(false),
        }
    }

    /// End of the next pass; None when the render is over.
    fn next_pass(&self, spp: u32) -> Option<u32> {
        if spp > 0 {
            self.tell(spp, self.samples.load(Ordering::Relaxed), self.rays.load(Ordering::Relaxed));
        }
        if self.over(spp) || (spp > 0 && self.stop.load(Ordering::Relaxed)) {
            return None;
        }
        let limit = self.settings.samples().unwrap_or(u32::MAX);
        let elapsed = self.start.elapsed();
        let per_sample = elapsed.as_secs_f64() / f64::from(spp.max(1));
        let left = self
            .settings
            .time_limit
            .map_or(f64::INFINITY, |limit| (limit.saturating_sub(elapsed)).as_secs_f64());
        // Two seconds a pass, and never more than the time that is left is likely to hold.
        let by_time = (2.0f64.min(left) / per_sample.max(1e-9)).clamp(1.0, 1e6) as u32;
        let size = if spp == 0 { 1 } else { by_time.min(spp.saturating_mul(4)) };
        let round = self.settings.round();
        Some(spp.saturating_add(size.next_multiple_of(round)).min(limit))
    }

    /// All samples are taken, or the time is up.
    fn over(&self, spp: u32) -> bool {
        let late = || self.settings.time_limit.is_some_and(|limit| self.start.elapsed() >= limit);
        self.settings.samples().is_some_and(|limit| spp >= limit) || (spp > 0 && late())
    }

    /// Whether the render ended because it was told to.
    fn stopped(&self, spp: u32) -> bool {
        self.stop.load(Ordering::Relaxed) && !self.over(spp)
    }

    fn tile_done(&self, added: u64, rays: u64, spp: u32) {
        let samples = self.samples.fetch_add(added, Ordering::Relaxed) + added;
        let rays = self.rays.fetch_add(rays, Ordering::Relaxed) + rays;
        let now = self.start.elapsed().as_millis() as u64;
        let told = self.told_ms.load(Ordering::Relaxed);
        let due = now >= told + 100;
        if due && self.told_ms.compare_exchange(told, now, Ordering::Relaxed, Ordering::Relaxed).is_ok() {
            self.tell(spp, samples, rays);
        }
    }

    fn tell(&self, spp: u32, samples: u64, rays: u64) {
        let elapsed = self.start.elapsed();
        let by_samples = self
            .settings
            .samples()
            .map_or(0.0, |spp| samples as f64 / (self.pixels.max(1) as f64 * f64::from(spp)));
        let by_time = self
            .settings
            .time_limit
            .map_or(0.0, |limit| elapsed.as_secs_f64() / limit.as_secs_f64().max(1e-9));
        let told = Progress { fraction: by_samples.max(by_time).min(1.0), spp, rays, elapsed };
        if (self.progress)(told).is_break() {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}

#[cfg(feature = "parallel")]
fn thread_count(settings: &Settings) -> usize {
    settings.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into)).max(1)
}

#[cfg(not(feature = "parallel"))]
fn thread_count(_: &Settings) -> usize {
    1
}

#[cfg(feature = "parallel")]
fn each_tile(threads: usize, tiles: &mut [Tile], work: impl Fn(&mut Tile) + Sync + Send) {
    use rayon::prelude::*;
    if threads > 1
        && let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build()
    {
        return pool.install(|| tiles.par_iter_mut().with_max_len(1).for_each(work));
    }
    tiles.iter_mut().for_each(work);
}

#[cfg(not(feature = "parallel"))]
fn each_tile(_: usize, tiles: &mut [Tile], work: impl Fn(&mut Tile)) {
    tiles.iter_mut().for_each(work);
}
