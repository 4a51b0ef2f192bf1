//! Everything that changes the estimate, or when it stops.

use crate::Aov;
use crate::effects::{Combine, Plans};
use crate::first_hit::Backfaces;
use crate::spread::Spread;
use dapple_camera::Filter;
use dapple_math::PixelRect;
use dapple_sampling::{Pattern, Plan};
use glam::Vec3;
use std::sync::Arc;
use std::time::Duration;

/// Who sums over what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The whole path is randomised, all integrals at once.
    #[default]
    Path,
    /// Every effect is an explicit integral with its own sample count and estimator.
    Distribution,
}

/// What to render and how; `Settings::default()` is the command line's default at 512×512.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Which tracer.
    pub method: Method,
    /// Full picture, in pixels.
    pub size: (u32, u32),
    /// Part of the picture to render; its pixels equal the full picture's.
    pub crop: Option<PixelRect>,
    /// Samples per pixel of the path tracer. `None`: no limit (then `time_limit` must be set). The distribution tracer
    /// goes over its points once, or again and again while `time_limit` lasts.
    pub spp: Option<u32>,
    /// Stop after this long, within a sample; what is kept is what all pixels have (see [`mod@crate::render`]).
    pub time_limit: Option<Duration>,
    /// How the points of each dimension are laid out.
    pub pattern: Pattern,
    /// Scattering events: 0 = emitters seen directly, 1 = direct light.
    pub max_bounces: u32,
    /// Russian roulette; without it paths end only at `max_bounces` or when they carry nothing.
    pub roulette: bool,
    /// Which of the independent renders.
    pub seed: u64,
    /// Worker threads; `None` = all the system grants. Changes no bit of the picture.
    pub threads: Option<usize>,
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
    /// takes `spp` samples of all at once, the distribution tracer as many as the pixel has points.
    pub plans: Plans,
    /// The distribution tracer's points over the environment where `plans.light` is off, which leaves the environment as
    /// it is. Else the environment has the light's points.
    pub sky: Plan,
    /// How the distribution tracer's integrals are put together.
    pub combine: Combine,
    /// Points of each integral below the first hit, nested.
    pub secondary: u32,
    /// Constant radiance that diffuse surfaces get from all around when interreflection is off. *Approximation*: stands
    /// in for the light that would have come by way of other surfaces.
    pub ambient: Vec3,
    /// Take the general path everywhere: every decision drawn, every question asked, though the scene needs none of it.
    /// Changes no bit of the picture; for comparison and debugging.
    pub general: bool,
    /// No sample is brighter than this in any channel: fewer sparks, less light. *Approximation*; what it takes away is
    /// told in [`crate::Ledger`]. `None`: nothing is clamped.
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
    /// Path tracer with `Sobol` or `Random` points: after the first [`crate::PILOT`] samples, further ones go where the
    /// error is. `spp` is then their mean over the picture.
    pub adaptive: bool,
    /// Shares of the samples that another render decided on; then `adaptive` has nothing to decide.
    pub spread: Option<Arc<Spread>>,
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
            method: Method::Path,
            size: (512, 512),
            crop: None,
            spp: Some(64),
            time_limit: None,
            pattern: Pattern::Sobol,
            max_bounces: 16,
            roulette: true,
            seed: 0,
            threads: None,
            filter: Filter::default(),
            aovs: Vec::new(),
            picture: true,
            transparent: false,
            backfaces: Backfaces::Camera,
            plans: Plans::default(),
            sky: Plans::default().light,
            combine: Combine::Nested,
            secondary: 1,
            ambient: Vec3::ZERO,
            general: false,
            clamp: None,
            soft_terminator: true,
            transparent_shadows: false,
            strategy: Strategy::Both,
            adaptive: false,
            spread: None,
        }
    }
}

impl Settings {
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
            Method::Path => 1,
            Method::Distribution => self.plans.pixel.count().max(1),
        }
    }

    /// Most samples per pixel, `None` without limit.
    pub fn samples(&self) -> Option<u32> {
        match self.method {
            Method::Distribution if self.time_limit.is_none() => Some(self.round()),
            Method::Distribution => None,
            Method::Path => self.spp,
        }
    }

    /// Whether samples go where the error is.
    pub(crate) fn is_adaptive(&self) -> bool {
        let sequence = matches!(self.pattern, Pattern::Sobol | Pattern::Random);
        self.adaptive && self.method == Method::Path && sequence && self.spread.is_none()
    }

    /// Points per block of the pattern: the sample count, or a fixed block when only time limits the render.
    pub(crate) fn block(&self) -> u32 {
        self.spp.unwrap_or(16).max(1)
    }
}
