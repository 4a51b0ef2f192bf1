//! The path tracer in batches: many samples at a time, stage by stage, over lanes.
//!
//! A batch holds all samples of some pixels in columns, one row per path. All of its paths are at the same depth: their
//! rays are intersected together, then surfaces, the environment, direct light and scattering are computed over lanes,
//! then shadow rays are tested. Paths that go on are packed into the rows of the next depth. What lanes do not cover is
//! computed row by row, by the functions of the path tracer: vertices with emission or near an edge; and scattering at
//! mirrors, of infinite throughput, and over the facets of smooth surfaces.
//!
//! Paths within bodies, at surfaces that they may pass straight, and at first hits that are recorded are followed by
//! [`PathState::step`](crate::path::PathState::step), as in the loop of single samples. The rays of all rows are first
//! traced as if every surface stopped them, because most surfaces do; only where a ray hits one that may not is it
//! traced again.
//!
//! Every formula is the same in both, so that a sample has the same bits as that of the kernel for single samples,
//! whatever the batch and the lanes: each row has its own sums, and its terms are added in the same order. Results are
//! kept by place, and added to the film in the order in which they were asked for.

mod arrive;
mod camera;
mod columns;
mod escapes;
mod lights;
mod points;
mod rows;
mod shade;
mod state;
mod surfaces;
mod textured;
mod tilts;
mod trace;

use crate::job::Job;
use crate::kernel::{Kernel, is_watched};
use columns::ROWS;
use dapple_math::lanes::Isa;
use lights::Lights;
use std::sync::Mutex;
use surfaces::Materials;
use trace::Shared;
pub(crate) use trace::{Batch, Done};

/// What the batches of a render share.
pub(crate) struct Batches {
    shared: Shared,
    rows: usize,
    /// Batches that no tile uses.
    idle: Mutex<Vec<Batch>>,
}

impl Batches {
    /// `None` if samples are computed one by one.
    pub fn new(job: &Job<'_>, kernel: Kernel<'_>) -> Option<Self> {
        let Kernel::Paths(_, sight) = kernel else { return None };
        let limits = &job.settings.limits;
        let rows = limits.batch.map_or(ROWS, |rows| (rows as usize).min(ROWS));
        if rows == 0 || !covers(job) {
            return None;
        }
        let (isa, watched) = (limits.isa.unwrap_or_else(Isa::fastest), is_watched(job));
        let (lights, materials) = (Lights::new(job.scene), Materials::new(job, watched));
        let shared = Shared { lights, materials, isa, sight, watched };
        Some(Self { shared, rows, idle: Mutex::default() })
    }

    /// An empty batch.
    pub fn take(&self, job: &Job<'_>) -> Batch {
        let idle = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        idle.unwrap_or_else(|| Batch::new(self.rows, job, &self.shared))
    }

    /// Gives a batch back.
    pub fn give(&self, mut batch: Batch) {
        batch.clear();
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(batch);
        }
    }

    /// Traces all samples of a batch; returns false if the job was stopped before that.
    pub fn trace(&self, job: &Job<'_>, batch: &mut Batch) -> bool {
        batch.trace(job, &self.shared)
    }
}

/// Whether batches cover everything that a job asks for.
fn covers(job: &Job<'_>) -> bool {
    job.sharp.is_empty()
        && !job.has_no_interreflection()
        && !job.lights_are_points()
        && !job.settings.general
        && job.scene.shared_places.is_none()
}
