//! The render loop: tiles, threads, passes, limits.
//!
//! A pass gives every pixel the same number of further samples. Passes start at one sample and grow to about a second.
//! A render can stop at any time, within a sample; what the pass under way has added is then taken back, so that every
//! pixel is equally sampled. Only the first pass is left as it is: some pixels have samples, others none. How a render is
//! cut into passes, tiles and threads changes no bit of the picture, for each pixel's samples are added in order.

use crate::clear;
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
use std::time::{Duration, Instant};
use watch::Watch;

mod checkpoint;
mod layers;
mod pilot;
mod pixels;
mod watch;

pub use checkpoint::{Checkpoint, Look};
pub use pixels::{render_pixels, render_pixels_until};

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
    /// Samples per pixel, on average. 0: the render ended before all pixels had one, and [`Film::count`] says which have;
    /// the layers then have one of sample counts.
    pub spp: u32,
    /// `progress` stopped the render before the samples or the time it was to take.
    pub stopped: bool,
    /// Time ended the render: before it had all samples, if their number was limited, or before all pixels had one.
    pub timed_out: bool,
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
    /// Beauty and the extra layers; of metadata only what says how to read a layer of ids.
    pub layers: Layers,
    /// What it took.
    pub stats: Stats,
    /// Which pixels got how many samples, where not all got the same.
    pub spread: Option<Arc<Spread>>,
    /// The samples that deviate most from their pixels.
    pub tail: Tail,
}

/// Of a worker, bytes: several times what a tree of rays takes even without optimisation; only what is used is memory.
#[cfg(feature = "parallel")]
const STACK: usize = 8 << 20;

/// Most bad samples reported by place.
const REPORTED: usize = 16;

/// Renders. `progress` may stop the render by returning `Break`; it is asked every 50 ms or so, by a thread of its own. What
/// the pass under way has added is then taken back, unless it is the first.
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
    look: Option<&mut Look<'_>>,
) -> Outcome {
    let watch = Watch::new(settings, progress);
    watch.during(|| passes((scene, camera, settings), &watch, look))
}

fn passes(
    (scene, camera, settings): (&Scene, &Camera, &Settings),
    watch: &Watch<'_>,
    mut look: Option<&mut Look<'_>>,
) -> Outcome {
    let job = Job { stop: &watch.stop, ..Job::new(scene, camera, settings) };
    let (kernel, name) = kernel::choose(&job);
    let mut tiles = Tile::cut(settings.rect(), settings);
    let threads = thread_count(settings);
    let mut pilot = Pilot::new(settings, &mut tiles);
    let (mut spp, mut enough) = (0, false);
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
            if watch.is_stopped() {
                return;
            }
            let before = tile.rays;
            tile.begin();
            let samples = tile.render(&job, kernel, (spp, end), spread.as_deref());
            watch.tile_done(samples, tile.rays - before);
        });
        if tiles.iter().any(|tile| tile.spp != end) {
            tiles.iter_mut().for_each(Tile::take_back);
            break;
        }
        tiles.iter_mut().for_each(Tile::keep);
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
            enough = look(&at).is_break();
            asked = at.asked.get().and_then(|n| n.checked_next_multiple_of(settings.round()));
            looking += now.elapsed();
            if enough {
                break;
            }
        }
    }
    let seconds = (watch.start.elapsed() - looking).as_secs_f64();
    let kernel = format!("{name}/{}", scene.world.kernel().name());
    let stopped = watch.was_told(spp) && !enough;
    let timed_out = !stopped && !enough && settings.samples().is_none_or(|limit| spp < limit);
    let ledger = Ledger {
        lights_culled: ledger::culled(scene),
        lights_unreachable: clear::unreachable(&job),
        ..Ledger::default()
    };
    let stats = Stats { seconds, spp, stopped, timed_out, threads, kernel, ledger, ..Stats::default() };
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
    let layers = layers::compose(job, &film, &tiles, stats.spp == 0);
    Outcome { film, layers, stats, spread, tail: checkpoint::tail(&tiles) }
}

#[cfg(feature = "parallel")]
fn thread_count(settings: &Settings) -> usize {
    settings.limits.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into)).max(1)
}

#[cfg(not(feature = "parallel"))]
fn thread_count(_: &Settings) -> usize {
    1
}

#[cfg(feature = "parallel")]
fn each_tile(threads: usize, tiles: &mut [Tile], work: impl Fn(&mut Tile) + Sync + Send) {
    use rayon::prelude::*;
    if threads > 1
        && let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build()
    {
        return pool.install(|| tiles.par_iter_mut().with_max_len(1).for_each(work));
    }
    tiles.iter_mut().for_each(work);
}

#[cfg(not(feature = "parallel"))]
fn each_tile(_: usize, tiles: &mut [Tile], work: impl Fn(&mut Tile)) {
    tiles.iter_mut().for_each(work);
}
