//! Next-event estimation: direct light at a vertex, found by light sampling.

use crate::bias_report::Truncation;
use crate::medium::MediumStack;
use crate::observer::PathObserver;
use crate::settings::Strategy;
use crate::shadow::{Passage, ShadowPath};
use crate::shared_place;
use crate::trace_context::TraceContext;
use crate::vertex::Vertex;
use crate::visibility::Visibility;
use dapple_lights::{Aiming, Light, LightSample};
use dapple_materials::{Lobe, Lobes};
use dapple_math::Ray;
use dapple_math::lanes::Real;
use dapple_sampling::{lanes, mis, warp};
use glam::{Vec2, Vec3};
use std::cell::Cell;

/// Direct lighting at a vertex: shadow rays, the media they cross, and the MIS strategy.
pub(crate) struct DirectLighting<'a, V> {
    pub context: TraceContext<'a, V>,
    pub vertex: &'a Vertex,
    pub media: Sides<'a>,
    pub strategy: Strategy,
    /// Maximum number of surfaces that a path from the vertex may still pass.
    pub reach: u32,
    /// Light lost because shadow rays crossed too many transparent surfaces.
    pub lost: Cell<Vec3>,
}

/// The bodies on both sides of a vertex; `near` is the side that the path arrived on.
#[derive(Clone, Copy)]
pub(crate) struct Sides<'a> {
    pub near: &'a MediumStack,
    pub far: &'a MediumStack,
}

/// One light sample of the path tracer.
#[derive(Clone, Copy)]
pub(crate) struct DirectSample {
    /// Random number for the choice of the light.
    pub uc: f32,
    /// Random numbers for the point on the light.
    pub u: Vec2,
    pub aiming: Aiming,
    /// Lobes that BSDF sampling continues the path with, which therefore find lights as well.
    pub followed: Lobes,
}

impl<V: Visibility> DirectLighting<'_, V> {
    /// Samples one light and one point on it: an estimate of ∫ f·L·|cosθ| dω over all lights. Counts its shadow ray in
    /// `rays`.
    #[inline(always)]
    pub fn one(&self, aim: &DirectSample, rays: &mut u64) -> Vec3 {
        let (scene, p) = (self.context.scene, self.vertex.surface.p);
        let Some(choice) = &scene.light_choice else { return Vec3::ZERO };
        let Some(chosen) = choice.sample(p, self.vertex.choice_normal(), aim.uc) else { return Vec3::ZERO };
        let light = &scene.lights[chosen.index];
        let Some(sample) = light.sample_as(aim.aiming, p, aim.u, self.context.time) else {
            return Vec3::ZERO;
        };
        let pdf = sample.pdf * chosen.pmf;
        let f_cos = self.received(light, &sample, pdf, aim.followed, false);
        let alone = || self.received_alone(light, &sample, pdf, aim.followed);
        self.arriving(chosen.index, &sample, pdf, (f_cos, alone), rays)
    }

    /// As [`Self::received`], for a light sample without a competing BSDF sample.
    #[cold]
    #[inline(never)]
    fn received_alone(&self, light: &Light, sample: &LightSample, pdf: f32, followed: Lobes) -> Vec3 {
        self.received(light, sample, pdf, followed, true)
    }

    /// f·cosθ for a light sample of density `pdf`. The `followed` lobes are weighted against BSDF sampling, unless the
    /// light sample is `alone`.
    #[inline(always)]
    fn received(&self, light: &Light, sample: &LightSample, pdf: f32, followed: Lobes, alone: bool) -> Vec3 {
        let (f_cos, bsdf_pdf) = self.vertex.f_cos_and_pdf(sample.wi, followed);
        let mut sum = f_cos * self.weight(sample.delta, pdf, if alone { 0.0 } else { bsdf_pdf });
        if followed != Lobes::ALL {
            let (f_cos, rest_pdf) = self.vertex.f_cos_and_pdf(sample.wi, Lobes::ALL.without(followed));
            let found = matches!(light, Light::Environment(_));
            sum += f_cos * self.weight(sample.delta, pdf, if found { rest_pdf } else { 0.0 });
        }
        sum
    }

    /// Radiance of the light sample that is scattered at the vertex, if it is not occluded. The first of the two values
    /// is f·cosθ towards the sample, weighted against BSDF sampling of the same light, the second is the same without
    /// competing BSDF samples.
    #[inline(always)]
    pub fn arriving(
        &self,
        light: usize,
        sample: &LightSample,
        pdf: f32,
        (f_cos, alone): (Vec3, impl Fn() -> Vec3),
        rays: &mut u64,
    ) -> Vec3 {
        if f_cos == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let radiance = match &sample.point {
            Some(point) if !sample.delta => {
                let time = self.context.time;
                self.context.scene.light_radiance(light as u32, point, sample.radiance, time)
            }
            _ => sample.radiance,
        };
        let value = f_cos * radiance / pdf;
        if value == Vec3::ZERO || value.is_nan() {
            return value;
        }
        let Some(o) = self.vertex.origin(sample.wi, &self.context) else { return Vec3::ZERO };
        let ray = sample.shadow_ray(o);
        *rays += 1;
        if V::PLAIN || self.context.job.plain_shadows {
            let is_hidden = match shared_place::of(self.context.scene).filter(|_| !V::PLAIN) {
                None => self.context.occluded(&ray),
                Some(places) => shared_place::is_hidden(places, (light, sample), o, &ray, &self.context),
            };
            return if is_hidden { Vec3::ZERO } else { value };
        }
        let ray = match shared_place::of(self.context.scene) {
            None => Some(ray),
            Some(places) => shared_place::segment_to_light(places, (light, sample), o, ray, &self.context),
        };
        let Some(ray) = ray else { return Vec3::ZERO };
        self.through(&ray, sample, value, &|| alone() * radiance / pdf)
    }

    /// The transmitted part of `value`, or, if no path can follow the same segment, of the value of `alone`.
    #[inline(never)]
    fn through(&self, ray: &Ray, sample: &LightSample, value: Vec3, alone: &impl Fn() -> Vec3) -> Vec3 {
        let Some(way) = self.shadow_path(ray, sample.wi, sample.distance, value) else { return Vec3::ZERO };
        let is_alone = way.passed > 0 && !sample.delta && self.is_alone(&way);
        way.transmittance * if is_alone { alone() } else { value }
    }

    /// The shadow path along `ray` towards `wi`, if it is not blocked; `value` is the contribution without transmission
    /// loss.
    fn shadow_path(&self, ray: &Ray, wi: Vec3, distance: f32, value: Vec3) -> Option<ShadowPath> {
        let ng = self.vertex.surface.ng;
        let is_far = wi.dot(ng) * self.vertex.wo.dot(ng) < 0.0;
        let stack = if is_far { self.media.far } else { self.media.near };
        match self.context.passage(ray, stack, distance) {
            Passage::Open(way) => Some(way),
            Passage::Blocked => None,
            Passage::Lost => {
                self.lost.set(self.lost.get() + value);
                None
            }
        }
    }

    /// Whether no path finds the light along this segment: it would be refracted, or would exceed the maximum number of
    /// bounces.
    fn is_alone(&self, way: &ShadowPath) -> bool {
        way.bent || way.passed > self.reach
    }

    /// Reports the lost light for a path of throughput `beta`.
    pub fn report_lost<O: PathObserver>(&self, beta: Vec3, observer: &mut O) {
        let lost = self.lost.get();
        if lost != Vec3::ZERO {
            observer.cut(Truncation::Panes, beta * lost);
        }
    }

    /// Environment light on a diffuse lobe that BSDF sampling does not continue, estimated with a cosine-distributed
    /// direction, one of `points`. `aimed` maps a light index and a density of the environment to the density of light
    /// sampling in that direction.
    pub fn sky_on_diffuse(
        &self,
        u: Vec2,
        points: f32,
        aimed: impl Fn(usize, f32) -> f32,
        rays: &mut u64,
    ) -> Vec3 {
        let Some(index) = self.context.scene.environment else { return Vec3::ZERO };
        let (Light::Environment(environment), true) =
            (&self.context.scene.lights[index as usize], self.vertex.bsdf.lobes().contains(Lobe::Diffuse))
        else {
            return Vec3::ZERO;
        };
        let wi = self.vertex.outward(warp::hemisphere_cosine(u));
        let (f_cos, pdf) = self.vertex.f_cos_and_pdf(wi, Lobes::of(Lobe::Diffuse));
        let value = f_cos * environment.radiance(wi) / pdf;
        if f_cos == Vec3::ZERO || value == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let Some(o) = self.vertex.origin(wi, &self.context) else { return Vec3::ZERO };
        let ray = Ray::new(o, wi);
        *rays += 1;
        let Some(way) = self.shadow_path(&ray, wi, f32::INFINITY, value) else { return Vec3::ZERO };
        let weight = match self.strategy {
            Strategy::Both => mis::power(points * pdf, aimed(index as usize, environment.pdf(wi))),
            Strategy::LightOnly if environment.is_sampled() => 0.0,
            _ => 1.0,
        };
        value * (weight * way.transmittance)
    }

    /// MIS weight of a light sample against BSDF sampling of the same light.
    pub fn weight(&self, delta: bool, pdf: f32, bsdf_pdf: f32) -> f32 {
        light_weight::<f32>(self.strategy, delta, pdf, bsdf_pdf)
    }
}

/// MIS weight of light samples of density `pdf` against BSDF sampling of the same light; those of `delta` lights have
/// no competitor.
#[inline(always)]
pub(crate) fn light_weight<R: Real>(strategy: Strategy, delta: R::Mask, pdf: R, bsdf_pdf: R) -> R {
    let one = R::splat(1.0);
    let weight = match strategy {
        Strategy::Both => lanes::mis::power(pdf, bsdf_pdf),
        Strategy::LightOnly => one,
        Strategy::BsdfOnly => R::splat(0.0),
    };
    R::select(delta, one, weight)
}
