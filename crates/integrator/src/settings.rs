//! Everything that changes the estimate, or when it stops.

mod check;

pub use check::SettingsError;

use crate::Aov;
use crate::allocation::SampleAllocation;
use crate::culling::Backfaces;
use crate::effects::{Combine, SampleSets};
use dapple_camera::Filter;
use dapple_math::PixelRect;
use dapple_sampling::{Pattern, SampleSet};
use glam::Vec3;
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

/// Bounces before roulette begins.
pub(crate) const ROULETTE_FROM: u32 = 3;

/// The integrator that renders, with the settings that it alone has.
#[derive(Clone, Debug)]
pub enum Method {
    /// The whole path is randomised, all integrals at once.
    Path(PathSettings),
    /// Every effect is an explicit integral with its own sample count and estimator.
    Distribution(DistributionSettings),
}

/// Which integrator renders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MethodKind {
    /// The path tracer.
    #[default]
    Path,
    /// The distribution ray tracer.
    Distribution,
}

/// Settings of the path tracer alone.
#[derive(Clone, Debug)]
pub struct PathSettings {
    /// Sample indices of every pixel. A range that ends at `u32::MAX` has no end: time or the caller stops the render.
    pub samples: Range<u32>,
    /// Size of the point set that the samples belong to; `None`: the end of the range. Parts of a render name that of the
    /// whole, so that together they have its samples.
    pub of: Option<u32>,
    /// Russian roulette; without it paths end only at `max_bounces` or when they carry nothing.
    pub roulette: bool,
    /// With `Sobol` or `Random` points: after the first [`crate::PILOT`] samples, further ones go where the error is. The
    /// number of samples is then the mean over the image.
    pub adaptive: bool,
    /// Shares of the samples that another render decided on; then `adaptive` has nothing to decide.
    pub allocation: Option<Arc<SampleAllocation>>,
}

impl Default for PathSettings {
    fn default() -> Self {
        Self { samples: 0..64, of: None, roulette: true, adaptive: false, allocation: None }
    }
}

/// Settings of the distribution ray tracer alone; the points of its integrals are in [`Settings::plans`].
#[derive(Clone, Debug)]
pub struct DistributionSettings {
    /// A round takes every pixel once through all points of its plan; further rounds have points of their own. A range
    /// that ends at `u32::MAX` has no end.
    pub rounds: Range<u32>,
    /// Points over the environment where `plans.light` is off, which leaves the environment as it is. Else the environment
    /// has the light's points.
    pub sky: SampleSet,
    /// How the integrals are put together.
    pub combine: Combine,
    /// Points of each integral below the first hit, nested.
    pub secondary: u32,
}

impl Default for DistributionSettings {
    fn default() -> Self {
        Self { rounds: 0..1, sky: SampleSets::default().light, combine: Combine::Nested, secondary: 1 }
    }
}

/// What ends a render before it has all samples, and what it may use. Changes no bit of what every pixel has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    /// Stop after this long, within a sample; what is kept is what all pixels have (see [`mod@crate::render`]).
    pub time: Option<Duration>,
    /// Worker threads; `None` = all the system grants.
    pub threads: Option<usize>,
}

/// What to render and how; `Settings::default()` is the command line's default at 512×512.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Which integrator, with what it alone needs.
    pub method: Method,
    /// Time and threads.
    pub limits: Limits,
    /// Full picture, in pixels.
    pub size: (u32, u32),
    /// Part of the picture to render; its pixels equal the full picture's.
    pub crop: Option<PixelRect>,
    /// How the points of each dimension are laid out.
    pub pattern: Pattern,
    /// Scattering events: 0 = emitters seen directly, 1 = direct light.
    pub max_bounces: u32,
    /// Which of the independent renders.
    pub seed: u64,
    /// Pixel filter.
    pub filter: Filter,
    /// Extra layers.
    pub aovs: Vec<Aov>,
    /// Render the picture itself. Without it only what first hits show is found out, and no light is followed.
    pub picture: bool,
    /// Camera rays that leave the scene without having met a surface see nothing instead of the environment, which still
    /// lights everything else and shows in mirrors and behind glass. The picture then has a channel A, the share of its
    /// samples that met a surface, and its colours are associated with it (premultiplied). Holes of MASK and BLEND
    /// materials are no surface; transmission is, for it is no coverage (glTF 2.0, KHR_materials_transmission), so that
    /// clear panes cover.
    pub transparent: bool,
    /// Which rays meet the back faces of single-sided materials.
    pub backfaces: Backfaces,
    /// Points of each of the distribution tracer's integrals; those with none are off in both tracers. The path tracer
    /// takes its samples of all at once, the distribution tracer as many as the pixel has points.
    pub plans: SampleSets,
    /// Constant radiance that diffuse surfaces get from all around when interreflection is off. *Approximation*: stands
    /// in for the light that would have come by way of other surfaces.
    pub ambient: Vec3,
    /// Take the general path everywhere: every decision drawn, every question asked, though the scene needs none of it.
    /// Changes no bit of the picture; for comparison and debugging.
    pub general: bool,
    /// No sample is brighter than this in any channel: fewer sparks, less light. *Approximation*; what it takes away is
    /// told in [`crate::BiasReport`]. `None`: nothing is clamped.
    pub clamp: Option<f32>,
    /// Light that a facet with smooth normals is lit by, but would shadow itself from, passes over the facet as over the
    /// round surface it stands for [Hanika 2021]; otherwise it ends at a hard edge along the facets. Flat surfaces, spheres
    /// and disks do not change. *Approximation*: what is in the way is looked for from above the facet.
    pub soft_terminator: bool,
    /// Shadow rays pass smooth surfaces of solid clear matter straight on, losing what is reflected and absorbed.
    /// *Approximation*: light is not bent there, so that there are no caustics; paths that would show the same light by
    /// way of refraction are left out. Thin walls and boundaries between equal indices are passed in any case, exactly.
    pub transparent_shadows: bool,
    /// Which of the two strategies for direct light take part; for tests and teaching.
    pub strategy: Strategy,
}

/// How light that falls directly on a surface is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strategy {
    /// Light and BSDF sampling, combined by the power heuristic [Veach 1997, §9.2].
    #[default]
    Both,
    /// Only by aiming at lights (and by delta lobes, which nothing can aim for).
    LightOnly,
    /// Only by following the BSDF (delta lights are still aimed at, for nothing can hit them).
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
    /// Defaults of the distribution ray tracer.
    pub fn distribution() -> Self {
        Self { method: Method::Distribution(DistributionSettings::default()), ..Self::default() }
    }

    /// Which integrator renders.
    pub fn kind(&self) -> MethodKind {
        match self.method {
            Method::Path(_) => MethodKind::Path,
            Method::Distribution(_) => MethodKind::Distribution,
        }
    }

    /// Settings of the path tracer, if that renders.
    pub fn path_tracer(&self) -> Option<&PathSettings> {
        match &self.method {
            Method::Path(path) => Some(path),
            Method::Distribution(_) => None,
        }
    }

    /// As [`path_tracer`](Self::path_tracer), to be changed.
    pub fn path_tracer_mut(&mut self) -> Option<&mut PathSettings> {
        match &mut self.method {
            Method::Path(path) => Some(path),
            Method::Distribution(_) => None,
        }
    }

    /// Settings of the distribution ray tracer, if that renders.
    pub fn distribution_tracer(&self) -> Option<&DistributionSettings> {
        match &self.method {
            Method::Path(_) => None,
            Method::Distribution(distribution) => Some(distribution),
        }
    }

    /// As [`distribution_tracer`](Self::distribution_tracer), to be changed.
    pub fn distribution_tracer_mut(&mut self) -> Option<&mut DistributionSettings> {
        match &mut self.method {
            Method::Path(_) => None,
            Method::Distribution(distribution) => Some(distribution),
        }
    }

    /// The same with another integrator, which gets its defaults; nothing changes if it renders already.
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

    /// The same with so many samples per pixel of the path tracer, `None` without end. Those of the distribution tracer
    /// follow from [`Settings::plans`]: there this changes nothing.
    #[must_use]
    pub fn with_spp(mut self, spp: impl Into<Option<u32>>) -> Self {
        if let Some(path) = self.path_tracer_mut() {
            path.samples = 0..spp.into().unwrap_or(u32::MAX);
        }
        self
    }

    /// The same, stopped after so long. The distribution tracer then takes as many rounds as there is time for.
    #[must_use]
    pub fn with_time_limit(mut self, time: impl Into<Option<Duration>>) -> Self {
        self.limits.time = time.into();
        let is_limited = self.limits.time.is_some();
        if let Some(distribution) = self.distribution_tracer_mut() {
            distribution.rounds = if is_limited { 0..u32::MAX } else { 0..1 };
        }
        self
    }

    /// The same on so many threads, `None` on all that the system grants.
    #[must_use]
    pub fn with_threads(mut self, threads: impl Into<Option<usize>>) -> Self {
        self.limits.threads = threads.into();
        self
    }

    /// The same with changes to the path tracer's settings, if that renders.
    #[must_use]
    pub fn with_path(mut self, change: impl FnOnce(&mut PathSettings)) -> Self {
        self.path_tracer_mut().map(change);
        self
    }

    /// The same with changes to the distribution tracer's settings, if that renders.
    #[must_use]
    pub fn with_distribution(mut self, change: impl FnOnce(&mut DistributionSettings)) -> Self {
        self.distribution_tracer_mut().map(change);
        self
    }
    /// The pixels to render: the crop, or the whole picture.
    pub fn rect(&self) -> PixelRect {
        self.crop.unwrap_or(PixelRect { x0: 0, y0: 0, x1: self.size.0, y1: self.size.1 })
    }

    /// Scattering events that are followed: none without a picture.
    pub fn bounces(&self) -> u32 {
        if self.picture { self.max_bounces } else { 0 }
    }

    /// Samples after which every pixel's estimate is whole: a distribution tracer's strata come in order.
    pub fn round(&self) -> u32 {
        match self.method {
            Method::Path(_) => 1,
            Method::Distribution(_) => self.plans.pixel.count().max(1),
        }
    }

    /// Sample indices of every pixel; without end if it ends at `u32::MAX`.
    pub fn sample_range(&self) -> Range<u32> {
        match &self.method {
            Method::Path(path) => path.samples.clone(),
            Method::Distribution(distribution) => {
                let Range { start, end } = distribution.rounds;
                start.saturating_mul(self.round())..end.saturating_mul(self.round())
            }
        }
    }

    /// The end of [`sample_range`](Self::sample_range), `None` without end.
    pub fn samples(&self) -> Option<u32> {
        Some(self.sample_range().end).filter(|end| *end < u32::MAX)
    }

    /// Samples per pixel of the path tracer; `None` without end and of the distribution tracer.
    pub fn spp(&self) -> Option<u32> {
        self.path_tracer().and_then(|_| self.samples())
    }

    /// Whether paths end by Russian roulette, if the path tracer renders; the distribution tracer's rays end by themselves.
    pub fn roulette(&self) -> bool {
        self.path_tracer().is_none_or(|path| path.roulette)
    }

    /// Whether samples are to go where the error is.
    pub fn adaptive(&self) -> bool {
        self.path_tracer().is_some_and(|path| path.adaptive)
    }

    /// Shares of the samples that another render decided on.
    pub fn allocation(&self) -> Option<&Arc<SampleAllocation>> {
        self.path_tracer().and_then(|path| path.allocation.as_ref())
    }

    /// How the distribution tracer's integrals are put together.
    pub fn combine(&self) -> Combine {
        self.distribution_tracer().map_or(Combine::Nested, |distribution| distribution.combine)
    }

    /// Whether samples go where the error is.
    pub(crate) fn is_adaptive(&self) -> bool {
        let sequence = matches!(self.pattern, Pattern::Sobol | Pattern::Random);
        self.adaptive() && sequence && self.allocation().is_none()
    }

    /// Points per block of the pattern: the sample count, or a fixed block when only time limits the render.
    pub(crate) fn block(&self) -> u32 {
        self.path_tracer().and_then(|path| path.of).or(self.spp()).unwrap_or(16).max(1)
    }
}
