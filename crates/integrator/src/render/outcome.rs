//! Results of a render, and its statistics.

use crate::allocation::SampleAllocation;
use crate::bias_report::BiasReport;
use crate::tail::Tail;
use crate::tile::BadSample;
use dapple_camera::Film;
use dapple_imaging::Layers;
use dapple_math::PixelRect;
use std::sync::Arc;
use std::time::Duration;

/// Progress of a render; reported several times per second.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Fraction done, 0 to 1, by samples or by time, whichever is further.
    pub fraction: f64,
    /// Samples per pixel that all pixels have.
    pub spp: u32,
    /// Rays traced so far.
    pub rays: u64,
    /// Time since rendering began.
    pub elapsed: Duration,
}

/// Statistics of a render.
#[derive(Clone, Debug, Default)]
pub struct Stats {
    /// Wall time of rendering alone, in seconds.
    pub seconds: f64,
    /// Number of camera samples.
    pub samples: u64,
    /// Number of rays: camera, scattered and shadow rays.
    pub rays: u64,
    /// Samples per pixel, on average. 0 if the render ended before all pixels had one; [`Film::count`] then tells which
    /// have, and the layers include the sample counts.
    pub spp: u32,
    /// Whether `progress` stopped the render before it reached its sample count or time limit.
    pub stopped: bool,
    /// Whether the time limit ended the render: before it reached its sample count, if there is one, or before all
    /// pixels had a sample.
    pub timed_out: bool,
    /// Number of worker threads.
    pub threads: usize,
    /// Names of the sample kernel and the traversal kernel.
    pub kernel: String,
    /// Pixels and indices of the first samples that were not finite.
    pub bad_samples: Vec<BadSample>,
    /// Number of samples that were not finite. They add zero and still count as samples.
    pub bad_sample_count: u64,
    /// Pixels whose computation panicked, which is an error of this program, each with the message. They have no
    /// samples and are black; all other pixels are as if nothing had happened.
    pub failures: Vec<(PixelRect, String)>,
    /// Events that biased the estimate.
    pub bias: BiasReport,
}

/// A finished render.
#[derive(Debug)]
pub struct Outcome {
    /// Means and variances of the pixels.
    pub film: Film,
    /// The beauty layer and the additional layers; the metadata contain only the names of ids.
    pub layers: Layers,
    /// Statistics of the render.
    pub stats: Stats,
    /// The sample allocation, if the pixels have different sample counts.
    pub allocation: Option<Arc<SampleAllocation>>,
    /// The largest differences of neighbouring samples.
    pub tail: Tail,
    /// The variance of the mean of each pixel after its first samples, see [`PilotResult`](super::PilotResult); none if the render
    /// does not have them.
    pub pilot: Option<Arc<Vec<f32>>>,
}
