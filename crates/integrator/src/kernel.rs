//! Sample kernels: the variants of the sample loop, one of which is chosen once per render.

use crate::custom::{self, Integrator};
use crate::distribution::pixel_point;
use crate::first_hit_sums::FirstHit;
use crate::job::Job;
use crate::observer::PathObserver;
use crate::path::path_sample;
use crate::settings::MethodKind;
use crate::visibility::{Cutout, Solid};
use glam::Vec3;

/// Radiance and filter weight of sample `index` of pixel (x, y); fills `first` if the kernel records the first hit, and
/// its bias report in any case.
type Sampler =
    fn(&Job<'_>, pixel: (u32, u32), index: u32, first: &mut FirstHit, rays: &mut u64) -> (Vec3, f32);

/// How samples are computed.
#[derive(Clone, Copy)]
pub(crate) enum Kernel<'a> {
    /// By the method in the settings.
    Own(Sampler),
    /// By paths, which batches compute as well.
    Paths(Sampler, Sight),
    /// By a custom integrator, in place of the method in the settings.
    Custom(&'a dyn Integrator),
}

impl Kernel<'_> {
    /// Computes one sample, see [`Sampler`].
    #[inline(always)]
    pub fn sample(
        &self,
        job: &Job<'_>,
        pixel: (u32, u32),
        index: u32,
        first: &mut FirstHit,
        rays: &mut u64,
    ) -> (Vec3, f32) {
        match self {
            Self::Own(sampler) | Self::Paths(sampler, _) => sampler(job, pixel, index, first, rays),
            Self::Custom(integrator) => custom::sample(*integrator, job, pixel, index, rays),
        }
    }
}

/// What stops the rays of paths in batches.
#[derive(Clone, Copy)]
pub(crate) enum Sight {
    /// Every surface, in a plain scene.
    Plain,
    /// Every surface.
    Solid,
    /// Surfaces with alpha tests.
    Cutout,
}

/// The smallest kernel of the settings' method that covers the job, and its name.
pub(crate) fn choose(job: &Job<'_>) -> (Kernel<'static>, &'static str) {
    let (alpha, watched) = (job.asks_alpha(), is_watched(job));
    let is_small = job.is_plain() && !watched;
    let (sampler, name) = if is_small { plain_kernel(job, alpha) } else { general(job, alpha, watched) };
    let sight = match alpha {
        false if is_small => Sight::Plain,
        false => Sight::Solid,
        true => Sight::Cutout,
    };
    let is_path = job.settings.kind() == MethodKind::Path;
    (if is_path { Kernel::Paths(sampler, sight) } else { Kernel::Own(sampler) }, name)
}

/// The smallest kernel for plain scenes without first hits.
fn plain_kernel(job: &Job<'_>, alpha: bool) -> (Sampler, &'static str) {
    match (job.settings.kind(), alpha) {
        (MethodKind::Path, false) => (path_plain, "path"),
        (MethodKind::Path, true) => (path_plain_alpha, "path+alpha"),
        (MethodKind::Distribution, false) => (distribution_plain, "distribution"),
        (MethodKind::Distribution, true) => (distribution_plain_alpha, "distribution+alpha"),
    }
}

/// Whether first hits are recorded.
pub(crate) fn is_watched(job: &Job<'_>) -> bool {
    let settings = job.settings;
    let asks = settings.aovs.iter().any(|aov| aov.needs_first_hit());
    cfg!(not(without = "layers")) && (settings.general || settings.transparent || asks)
}

/// The smallest kernel for scenes that are not plain, or with first hits.
fn general(job: &Job<'_>, alpha: bool, watched: bool) -> (Sampler, &'static str) {
    match (job.settings.kind(), alpha, watched) {
        (MethodKind::Path, false, false) => (path_solid, "path"),
        (MethodKind::Path, false, true) => (path_solid_watched, "path+first-hit"),
        (MethodKind::Path, true, false) => (path_alpha, "path+alpha"),
        (MethodKind::Path, true, true) => (path_alpha_watched, "path+alpha+first-hit"),
        (MethodKind::Distribution, false, false) => (distribution_solid, "distribution"),
        (MethodKind::Distribution, false, true) => (distribution_solid_watched, "distribution+first-hit"),
        (MethodKind::Distribution, true, false) => (distribution_alpha, "distribution+alpha"),
        (MethodKind::Distribution, true, true) => {
            (distribution_alpha_watched, "distribution+alpha+first-hit")
        }
    }
}

macro_rules! kernel {
    ($name:ident, $sample:ident, $visibility:expr, $first:ident, $observer:expr) => {
        fn $name(
            job: &Job<'_>,
            pixel: (u32, u32),
            index: u32,
            $first: &mut FirstHit,
            rays: &mut u64,
        ) -> (Vec3, f32) {
            $sample(job, $visibility(job), pixel, index, $observer, rays)
        }
    };
}

fn solid(_: &Job<'_>) -> Solid<false> {
    Solid
}

pub(crate) fn cutout<const PLAIN: bool>(job: &Job<'_>) -> Cutout<PLAIN> {
    Cutout { cull_backfaces: job.is_culled() }
}

fn plain(_: &Job<'_>) -> Solid<true> {
    Solid
}

kernel!(path_plain, path_sample, plain, first, &mut first.bias);
kernel!(path_plain_alpha, path_sample, cutout::<true>, first, &mut first.bias);
kernel!(distribution_plain, pixel_point, plain, first, &mut first.bias);
kernel!(distribution_plain_alpha, pixel_point, cutout::<true>, first, &mut first.bias);

kernel!(path_solid, path_sample, solid, first, &mut first.bias);
kernel!(path_solid_watched, path_sample, solid, first, first);
kernel!(path_alpha, path_sample, cutout::<false>, first, &mut first.bias);
kernel!(path_alpha_watched, path_sample, cutout::<false>, first, first);
kernel!(distribution_solid, pixel_point, solid, first, &mut first.bias);
kernel!(distribution_solid_watched, pixel_point, solid, first, first);
kernel!(distribution_alpha, pixel_point, cutout::<false>, first, &mut first.bias);
kernel!(distribution_alpha_watched, pixel_point, cutout::<false>, first, first);

/// One sample of the settings' method, with an observer.
pub(crate) fn observed<O: PathObserver>(
    job: &Job<'_>,
    pixel: (u32, u32),
    index: u32,
    observer: &mut O,
    rays: &mut u64,
) -> (Vec3, f32) {
    match (job.settings.kind(), job.asks_alpha()) {
        (MethodKind::Path, false) => path_sample(job, solid(job), pixel, index, observer, rays),
        (MethodKind::Path, true) => path_sample(job, cutout::<false>(job), pixel, index, observer, rays),
        (MethodKind::Distribution, false) => pixel_point(job, solid(job), pixel, index, observer, rays),
        (MethodKind::Distribution, true) => {
            pixel_point(job, cutout::<false>(job), pixel, index, observer, rays)
        }
    }
}
