//! Render settings: everything that affects the estimate, and the limits of a render.

mod check;

pub use check::SettingsError;

use crate::Aov;
use crate::allocation::{PILOT, SampleAllocation};
use crate::culling::Backfaces;
use crate::effects::{Combine, SampleSets};
use dapple_camera::Filter;
use dapple_math::PixelRect;
use dapple_math::lanes::Isa;
use dapple_sampling::{Pattern, SampleSet};
use glam::Vec3;
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

/// Number of bounces before Russian roulette begins.
pub(crate) const ROULETTE_FROM: u32 = 2;

/// Survival probability of Russian roulette per unit of throughput (docs/science.md, "Russian roulette").
pub(crate) const ROULETTE_SCALE: f32 = 4.0;

/// The integrator, with the settings that only it has.
#[derive(Clone, Debug)]
pub enum Method {
    /// The path tracer: all integrals are estimated together by random paths.
    Path(PathSettings),
    /// The distribution ray tracer: every effect is an explicit integral with its own sample count and estimator.
    Distribution(DistributionSettings),
}

/// Kind of the integrator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MethodKind {
    /// The path tracer.
    #[default]
    Path,
    /// The distribution ray tracer.
    Distribution,
}

/// Settings of the path tracer.
#[derive(Clone, Debug)]
pub struct PathSettings {
    /// Sample indices of every pixel. A range that ends at `u32::MAX` is unlimited: a time limit or the caller stops
    /// the render.
    pub samples: Range<u32>,
    /// Size of the point set that the samples belong to; `None`: the end of the range. Partial renders specify the size
    /// of the whole, so that together they have the same samples.
    pub of: Option<u32>,
    /// Russian roulette; without it paths end only at `max_bounces` or when their throughput is zero.
    pub roulette: bool,
    /// With `Sobol` or `Random` points: after the first [`crate::PILOT`] samples, distribute further samples by
    /// estimated error. The number of samples is then the mean over the image.
    pub adaptive: bool,
    /// Sample allocation of another render, which replaces the `adaptive` pilot.
    pub allocation: Option<Arc<SampleAllocation>>,
}

impl Default for PathSettings {
    fn default() -> Self {
        Self { samples: 0..64, of: None, roulette: true, adaptive: false, allocation: None }
    }
}

/// Settings of the distribution ray tracer; the sample sets of its integrals are in [`Settings::plans`].
#[derive(Clone, Debug)]
pub struct DistributionSettings {
    /// In one round, every pixel takes all points of its sample set once; further rounds have different points. A range
    /// that ends at `u32::MAX` is unlimited.
    pub rounds: Range<u32>,
    /// Sample indices of every pixel, in place of those of `rounds`: a part of a render. Index i is point i mod n of
    /// round i div n, for n points of the pixel.
    pub samples: Option<Range<u32>>,
    /// Sample set over the environment if `plans.light` is off, which does not affect the environment. Otherwise the
    /// environment uses the light's sample set.
    pub sky: SampleSet,
    /// How the integrals are combined.
    pub combine: Combine,
    /// In nested mode, number of points of each integral below the first hit.
    pub secondary: u32,
}

impl Default for DistributionSettings {
    fn default() -> Self {
        let sky = SampleSets::default().light;
        Self { rounds: 0..1, samples: None, sky, combine: Combine::Nested, secondary: 1 }
    }
}

/// Limits that end a render early, and the resources that it may use. They change no bit of the samples that every
/// pixel has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    /// Stop after this time, within a sample; the samples that all pixels have are kept (see [`mod@crate::render`]).
    pub time: Option<Duration>,
    /// Number of worker threads; `None`: all that the system grants.
    pub threads: Option<usize>,
    /// Instruction set of the batches of the path tracer; `None`: the fastest that this machine supports.
    pub isa: Option<Isa>,
    /// Number of samples of a batch, where batches are used; at most 1024; 0 for none, `None` for that number.
    pub batch: Option<u32>,
}

/// What to render and how; `Settings::default()` is the command line's default at 512×512.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The integrator and its own settings.
    pub method: Method,
    /// Time limit and thread count.
    pub limits: Limits,
    /// Size of the full image, in pixels.
    pub size: (u32, u32),
    /// Part of the image to render; its pixels are equal to those of the full image.
    pub crop: Option<PixelRect>,
    /// Sampling pattern of each dimension.
    pub pattern: Pattern,
    /// Maximum number of scattering events: 0 = directly visible emitters, 1 = direct light.
    pub max_bounces: u32,
    /// Seed; renders with different seeds are independent.
    pub seed: u64,
    /// Pixel filter.
    pub filter: Filter,
    /// Additional layers.
    pub aovs: Vec<Aov>,
    /// Whether to render the image itself. Without it only the first hits are computed, and no light is traced.
    pub picture: bool,
    /// Whether camera rays that leave the scene without hitting a surface return nothing instead of the environment,
    /// which still lights the scene and is visible in mirrors and behind glass. The image then has a channel A, the
    /// share of the samples that hit a surface, and its colours are associated (premultiplied). Holes of MASK and BLEND
    /// materials do not count as surface; transmissive materials do, because transmission is not coverage (glTF 2.0,
    /// KHR_materials_transmission), so that transparent panes are opaque in alpha.
    pub transparent: bool,
    /// Which rays hit the back faces of single-sided materials.
    pub backfaces: Backfaces,
    /// Sample sets of the distribution tracer's integrals; integrals with a count of 0 are off in both tracers. The
    /// path tracer samples all integrals together, the distribution tracer takes as many samples as the pixel has
    /// points.
    pub plans: SampleSets,
    /// Constant ambient radiance on diffuse surfaces when interreflection is off. *Approximation*: replaces the
    /// indirect light from other surfaces.
    pub ambient: Vec3,
    /// Use the general code path everywhere: draw every decision and evaluate every feature, even if the scene does not
    /// need it. Changes no bit of the image; for comparison and debugging.
    pub general: bool,
    /// Maximum value of a sample in any channel, which suppresses fireflies and loses light. *Approximation*; the
    /// removed energy is in [`crate::BiasReport`]. `None`: nothing is clamped.
    pub clamp: Option<f32>,
    /// Soft shadow terminator: light that illuminates a smooth-shaded facet but would be blocked by the facet itself
    /// passes over it as over the smooth surface that the facet approximates [Hanika 2021]; otherwise there is a hard
    /// edge along the facets. Flat surfaces, spheres and disks do not change. *Approximation*: occlusion is tested from
    /// a point above the facet.
    pub soft_terminator: bool,
    /// Whether shadow rays pass smooth surfaces of solid transparent bodies in a straight line, with the loss by
    /// reflection and absorption. *Approximation*: light is not refracted there, so that there are no caustics; paths
    /// that would find the same light by refraction are omitted. Thin walls and boundaries between equal indices are
    /// always passed, exactly.
    pub transparent_shadows: bool,
    /// The strategies used for direct light; for tests and teaching.
    pub strategy: Strategy,
}

/// Sampling strategy for direct light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strategy {
    /// Light and BSDF sampling, combined by the power heuristic [Veach 1997, §9.2].
    #[default]
    Both,
    /// Only light sampling (and delta lobes, which light sampling cannot handle).
    LightOnly,
    /// Only BSDF sampling (delta lights are still sampled, because no ray can hit them).
    BsdfOnly,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Path(PathSettings::default()),
            limits: Limits::default(),
            size: (512, 512),
            crop: None,
            pattern: Pattern::Sobol,
            max_bounces: 16,
            seed: 0,
            filter: Filter::default(),
            aovs: Vec::new(),
            picture: true,
            transparent: false,
            backfaces: Backfaces::Camera,
            plans: SampleSets::default(),
            ambient: Vec3::ZERO,
            general: false,
            clamp: None,
            soft_terminator: true,
            transparent_shadows: false,
            strategy: Strategy::Both,
        }
    }
}

impl Settings {
    /// Default settings of the distribution ray tracer.
    pub fn distribution() -> Self {
        Self { method: Method::Distribution(DistributionSettings::default()), ..Self::default() }
    }

    /// Kind of the integrator.
    pub fn kind(&self) -> MethodKind {
        match self.method {
            Method::Path(_) => MethodKind::Path,
            Method::Distribution(_) => MethodKind::Distribution,
        }
    }

    /// Settings of the path tracer, if it is the integrator.
    pub fn path_tracer(&self) -> Option<&PathSettings> {
        match &self.method {
            Method::Path(path) => Some(path),
            Method::Distribution(_) => None,
        }
    }

    /// Mutable settings of the path tracer, if it is the integrator.
    pub fn path_tracer_mut(&mut self) -> Option<&mut PathSettings> {
        match &mut self.method {
            Method::Path(path) => Some(path),
            Method::Distribution(_) => None,
        }
    }

    /// Settings of the distribution ray tracer, if it is the integrator.
    pub fn distribution_tracer(&self) -> Option<&DistributionSettings> {
        match &self.method {
            Method::Path(_) => None,
            Method::Distribution(distribution) => Some(distribution),
        }
    }

    /// Mutable settings of the distribution ray tracer, if it is the integrator.
    pub fn distribution_tracer_mut(&mut self) -> Option<&mut DistributionSettings> {
        match &mut self.method {
            Method::Path(_) => None,
            Method::Distribution(distribution) => Some(distribution),
        }
    }

    /// Selects the integrator, with its default settings; no change if it is selected already.
    #[must_use]
    pub fn with_method(mut self, kind: MethodKind) -> Self {
        if self.kind() != kind {
            self.method = match kind {
                MethodKind::Path => Method::Path(PathSettings::default()),
                MethodKind::Distribution => Method::Distribution(DistributionSettings::default()),
            };
        }
        self
    }

    /// Sets the samples per pixel of the path tracer, `None` for no limit. No effect on the distribution tracer, whose
    /// samples follow from [`Settings::plans`].
    #[must_use]
    pub fn with_spp(mut self, spp: impl Into<Option<u32>>) -> Self {
        if let Some(path) = self.path_tracer_mut() {
            path.samples = 0..spp.into().unwrap_or(u32::MAX);
        }
        self
    }

    /// Sets the time limit. The distribution tracer then takes as many rounds as the time allows.
    #[must_use]
    pub fn with_time_limit(mut self, time: impl Into<Option<Duration>>) -> Self {
        self.limits.time = time.into();
        let is_limited = self.limits.time.is_some();
        if let Some(distribution) = self.distribution_tracer_mut() {
            distribution.rounds = if is_limited { 0..u32::MAX } else { 0..1 };
        }
        self
    }

    /// Sets the number of threads, `None` for all that the system grants.
    #[must_use]
    pub fn with_threads(mut self, threads: impl Into<Option<usize>>) -> Self {
        self.limits.threads = threads.into();
        self
    }

    /// Changes the settings of the path tracer, if it is the integrator.
    #[must_use]
    pub fn with_path(mut self, change: impl FnOnce(&mut PathSettings)) -> Self {
        self.path_tracer_mut().map(change);
        self
    }

    /// Changes the settings of the distribution tracer, if it is the integrator.
    #[must_use]
    pub fn with_distribution(mut self, change: impl FnOnce(&mut DistributionSettings)) -> Self {
        self.distribution_tracer_mut().map(change);
        self
    }
    /// The pixels to render: the crop, or the whole image.
    pub fn rect(&self) -> PixelRect {
        self.crop.unwrap_or(PixelRect { x0: 0, y0: 0, x1: self.size.0, y1: self.size.1 })
    }

    /// Maximum number of scattering events; 0 if the image itself is not rendered.
    pub fn bounces(&self) -> u32 {
        if self.picture { self.max_bounces } else { 0 }
    }

    /// Number of samples after which every pixel estimate is complete: the strata of the distribution tracer come in
    /// order.
    pub fn round(&self) -> u32 {
        match self.method {
            Method::Path(_) => 1,
            Method::Distribution(_) => self.plans.pixel.count().max(1),
        }
    }

    /// Sample indices of every pixel; unlimited if the range ends at `u32::MAX`.
    pub fn sample_range(&self) -> Range<u32> {
        match &self.method {
            Method::Path(path) => path.samples.clone(),
            Method::Distribution(distribution) => distribution.samples.clone().unwrap_or_else(|| {
                let Range { start, end } = distribution.rounds;
                start.saturating_mul(self.round())..end.saturating_mul(self.round())
            }),
        }
    }

    /// The end of [`sample_range`](Self::sample_range), `None` if unlimited.
    pub fn samples(&self) -> Option<u32> {
        Some(self.sample_range().end).filter(|end| *end < u32::MAX)
    }

    /// Samples per pixel of the path tracer; `None` if unlimited, and for the distribution tracer.
    pub fn spp(&self) -> Option<u32> {
        self.path_tracer().and_then(|_| self.samples())
    }

    /// Whether Russian roulette ends paths; also true for the distribution tracer, which does not use roulette.
    pub fn roulette(&self) -> bool {
        self.path_tracer().is_none_or(|path| path.roulette)
    }

    /// Whether adaptive sampling is requested.
    pub fn adaptive(&self) -> bool {
        self.path_tracer().is_some_and(|path| path.adaptive)
    }

    /// The sample allocation of another render, if given.
    pub fn allocation(&self) -> Option<&Arc<SampleAllocation>> {
        self.path_tracer().and_then(|path| path.allocation.as_ref())
    }

    /// How the distribution tracer's integrals are combined.
    pub fn combine(&self) -> Combine {
        self.distribution_tracer().map_or(Combine::Nested, |distribution| distribution.combine)
    }

    /// Number of pilot samples of every pixel ([`crate::render_pilot`]): [`crate::PILOT`], or all if there are fewer;
    /// for the distribution tracer one round. None if that has more points, or if there is no image.
    pub fn pilot_samples(&self) -> Option<u32> {
        let count = match &self.method {
            Method::Path(path) => PILOT.min(path.of.unwrap_or(path.samples.end)),
            Method::Distribution(_) => self.round(),
        };
        Some(count).filter(|count| self.picture && *count <= PILOT)
    }

    /// Whether this render has to compute a sample allocation.
    pub(crate) fn is_adaptive(&self) -> bool {
        let sequence = matches!(self.pattern, Pattern::Sobol | Pattern::Random);
        self.adaptive() && sequence && self.allocation().is_none()
    }

    /// Points per block of the pattern: the sample count, or a fixed block if only time limits the render.
    pub(crate) fn block(&self) -> u32 {
        self.path_tracer().and_then(|path| path.of).or(self.spp()).unwrap_or(16).max(1)
    }
}
