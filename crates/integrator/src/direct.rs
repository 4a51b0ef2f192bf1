//! Next-event estimation: light that falls directly on a vertex, found by aiming at a light.

use crate::bias_report::Truncation;
use crate::medium::MediumStack;
use crate::observer::PathObserver;
use crate::settings::Strategy;
use crate::shadow::{Passage, Way};
use crate::shared_place;
use crate::trace_context::TraceContext;
use crate::vertex::Vertex;
use crate::visibility::Visibility;
use dapple_lights::{Aiming, Light, LightSample};
use dapple_materials::{Lobe, Lobes};
use dapple_math::Ray;
use dapple_sampling::{mis, warp};
use glam::{Vec2, Vec3};
use std::cell::Cell;

/// The way from a vertex to a light, and what may stand in it.
pub(crate) struct DirectLighting<'a, V> {
    pub context: TraceContext<'a, V>,
    pub vertex: &'a Vertex,
    pub media: Sides<'a>,
    pub strategy: Strategy,
    /// Surfaces that a path from the vertex may still pass.
    pub reach: u32,
    /// Light lost among too many clear surfaces.
    pub lost: Cell<Vec3>,
}

/// The bodies on both sides of a vertex, as seen from where the path came.
#[derive(Clone, Copy)]
pub(crate) struct Sides<'a> {
    pub near: &'a MediumStack,
    pub far: &'a MediumStack,
}

/// One attempt of the path tracer to find light.
#[derive(Clone, Copy)]
pub(crate) struct DirectSample {
    /// Chooses the light.
    pub uc: f32,
    /// The point on it.
    pub u: Vec2,
    pub aiming: Aiming,
    /// Lobes by which the path may go on, and so find lights as well.
    pub followed: Lobes,
}

impl<V: Visibility> DirectLighting<'_, V> {
    /// One light, one point on it: an estimate of ∫ f·L·|cosθ| dω over all lights. Counts its shadow ray in `rays`.
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

    /// As [`Self::received`], of a light sample that is alone.
    #[cold]
    #[inline(never)]
    fn received_alone(&self, light: &Light, sample: &LightSample, pdf: f32, followed: Lobes) -> Vec3 {
        self.received(light, sample, pdf, followed, true)
    }

    /// f·cosθ towards a light sample of density `pdf`, what is followed weighted against being found that way unless the light
    /// sample is `alone`.
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

    /// What of the light sample's radiance leaves the vertex, unless something stands in the way. First f·cosθ towards
    /// it, weighted against rays that find the same light, then the same as if there were none.
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
            Some(places) => shared_place::way(places, (light, sample), o, ray, &self.context),
        };
        let Some(ray) = ray else { return Vec3::ZERO };
        self.through(&ray, sample, value, &|| alone() * radiance / pdf)
    }

    /// What comes through of `value`, or where no path takes the same way, of what the light sample is worth `alone`.
    #[inline(never)]
    fn through(&self, ray: &Ray, sample: &LightSample, value: Vec3, alone: &impl Fn() -> Vec3) -> Vec3 {
        let Some(way) = self.way(ray, sample.wi, sample.distance, value) else { return Vec3::ZERO };
        let is_alone = way.passed > 0 && !sample.delta && self.is_alone(&way);
        way.transmittance * if is_alone { alone() } else { value }
    }

    /// The way along a shadow ray towards `wi`, if light comes through; `value`: what then arrives at most.
    fn way(&self, ray: &Ray, wi: Vec3, distance: f32, value: Vec3) -> Option<Way> {
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

    /// Whether no path finds the light on this way: it would be bent, or have more bounces than are followed.
    fn is_alone(&self, way: &Way) -> bool {
        way.bent || way.passed > self.reach
    }

    /// Writes down what was lost, for a path of throughput `beta`.
    pub fn tell<O: PathObserver>(&self, beta: Vec3, observer: &mut O) {
        let lost = self.lost.get();
        if lost != Vec3::ZERO {
            observer.cut(Truncation::Panes, beta * lost);
        }
    }

    /// Light of the environment on a diffuse lobe that is not followed, found in a direction even in cosine. `aimed`
    /// gives the density of aiming there, for a density of the environment's own; of such directions there are `points`.
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
        let Some(way) = self.way(&ray, wi, f32::INFINITY, value) else { return Vec3::ZERO };
        let weight = match self.strategy {
            Strategy::Both => mis::power(points * pdf, aimed(index as usize, environment.pdf(wi))),
            Strategy::LightOnly if environment.is_sampled() => 0.0,
            _ => 1.0,
        };
        value * (weight * way.transmittance)
    }

    /// Weight of a light sample against the BSDF finding the same light.
    pub fn weight(&self, delta: bool, pdf: f32, bsdf_pdf: f32) -> f32 {
        match self.strategy {
            _ if delta => 1.0,
            Strategy::Both => mis::power(pdf, bsdf_pdf),
            Strategy::LightOnly => 1.0,
            Strategy::BsdfOnly => 0.0,
        }
    }
}
