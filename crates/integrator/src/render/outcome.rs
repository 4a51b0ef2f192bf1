//! What a render gives, and what it took.

use crate::allocation::SampleAllocation;
use crate::bias_report::BiasReport;
use crate::tail::Tail;
use crate::tile::BadSample;
use dapple_camera::Film;
use dapple_imaging::Layers;
use std::sync::Arc;
use std::time::Duration;

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
    pub bias: BiasReport,
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
    pub allocation: Option<Arc<SampleAllocation>>,
    /// The samples that deviate most from their pixels.
    pub tail: Tail,
}
