//! Next-event estimation: light that falls directly on a vertex, found by aiming at a light.

use crate::medium::Medium;
use crate::settings::Strategy;
use crate::shared_place;
use crate::vertex::{Around, Vertex};
use crate::visibility::Visibility;
use dapple_geometry::Ray;
use dapple_geometry::offset::{UNIT_ROUNDOFF, offset_origin};
use dapple_lights::{Aiming, Light, LightSample};
use dapple_materials::{Lobe, Lobes};
use dapple_sampling::{mis, warp};
use glam::{Vec2, Vec3};

/// The way from a vertex to a light, and what may stand in it.
pub(crate) struct Beam<'a, V> {
    pub around: Around<'a, V>,
    pub vertex: &'a Vertex,
    /// What the way leads through, if that absorbs.
    pub medium: Option<Medium>,
    pub strategy: Strategy,
}

/// One attempt of the path tracer to find light.
#[derive(Clone, Copy)]
pub(crate) struct Aim {
    /// Chooses the light.
    pub uc: f32,
    /// The point on it.
    pub u: Vec2,
    pub aiming: Aiming,
    /// Lobes by which the path may go on, and so find lights as well.
    pub followed: Lobes,
}

impl<V: Visibility> Beam<'_, V> {
    /// One light, one point on it: an estimate of ∫ f·L·|cosθ| dω over all lights. Counts its shadow ray in `rays`.
    #[inline(always)]
    pub fn one(&self, aim: &Aim, rays: &mut u64) -> Vec3 {
        let (scene, p) = (self.around.scene, self.vertex.surface.p);
        let Some(choice) = &scene.light_choice else { return Vec3::ZERO };
        let Some(chosen) = choice.sample(p, self.vertex.choice_normal(), aim.uc) else { return Vec3::ZERO };
        let light = &scene.lights[chosen.index];
        let Some(sample) = light.sample_as(aim.aiming, p, aim.u, self.around.time) else { return Vec3::ZERO };
        let pdf = sample.pdf * chosen.pmf;
        let f_cos = self.received(light, &sample, pdf, aim.followed);
        self.arriving(chosen.index, &sample, pdf, f_cos, rays)
    }

    /// f·cosθ towards a light sample of density `pdf`, what is followed weighted against being found that way.
    fn received(&self, light: &Light, sample: &LightSample, pdf: f32, followed: Lobes) -> Vec3 {
        let (f_cos, bsdf_pdf) = self.vertex.f_cos_and_pdf(sample.wi, followed);
        let mut sum = f_cos * self.weight(sample.delta, pdf, bsdf_pdf);
        if followed != Lobes::ALL {
            let (f_cos, rest_pdf) = self.vertex.f_cos_and_pdf(sample.wi, Lobes::ALL.without(followed));
            let found = matches!(light, Light::Environment(_));
            sum += f_cos * self.weight(sample.delta, pdf, if found { rest_pdf } else { 0.0 });
        }
        sum
    }

    /// What of the light sample's radiance leaves the vertex, unless something stands in the way; `f_cos` weighted.
    pub fn arriving(
        &self,
        light: usize,
        sample: &LightSample,
        pdf: f32,
        f_cos: Vec3,
        rays: &mut u64,
    ) -> Vec3 {
        if f_cos == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let radiance = match &sample.point {
            Some(point) if !sample.delta => {
                let time = self.around.time;
                self.around.scene.light_radiance(light as u32, point, sample.radiance, time)
            }
            _ => sample.radiance,
        };
        let value = f_cos * radiance / pdf;
        if value == Vec3::ZERO || value.is_nan() {
            return value;
        }
        let Some(o) = self.vertex.origin(sample.wi, &self.around) else { return Vec3::ZERO };
        let ray = shadow_ray(o, sample);
        *rays += 1;
        let is_hidden = match shared_place::of(self.around.scene) {
            None => self.around.blocked(&ray),
            Some(places) => shared_place::is_hidden(places, (light, sample), o, &ray, &self.around),
        };
        if is_hidden {
            return Vec3::ZERO;
        }
        value * self.through(sample.distance)
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
        let Some(index) = self.around.scene.environment else { return Vec3::ZERO };
        let (Light::Environment(environment), true) =
            (&self.around.scene.lights[index as usize], self.vertex.bsdf.lobes().contains(Lobe::Diffuse))
        else {
            return Vec3::ZERO;
        };
        let wi = self.vertex.outward(warp::hemisphere_cosine(u));
        let (f_cos, pdf) = self.vertex.f_cos_and_pdf(wi, Lobes::of(Lobe::Diffuse));
        let value = f_cos * environment.radiance(wi) / pdf;
        if f_cos == Vec3::ZERO || value == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let Some(o) = self.vertex.origin(wi, &self.around) else { return Vec3::ZERO };
        let ray = Ray::new(o, wi);
        *rays += 1;
        if self.around.blocked(&ray) {
            return Vec3::ZERO;
        }
        let weight = match self.strategy {
            Strategy::Both => mis::power(points * pdf, aimed(index as usize, environment.pdf(wi))),
            Strategy::LightOnly if environment.is_sampled() => 0.0,
            _ => 1.0,
        };
        value * (weight * self.through(f32::INFINITY))
    }

    /// What is left of light after `distance`.
    fn through(&self, distance: f32) -> Vec3 {
        self.medium.map_or(Vec3::ONE, |medium| medium.transmittance(distance))
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

/// Where shadow rays end. From origin to target a direction is rounded by half an ulp per axis, so that its end lies up to
/// |n|·|d|·2⁻²⁴ before or behind the target, measured along the light's normal; by that, the light would shadow its own
/// samples where its coordinates, and with them its error box, are small against the distance. Covers it for all but the
/// last 4° to the light's plane.
const END: f32 = 1.0 - 16.0 * UNIT_ROUNDOFF;

/// From `o` to outside the light's error box; t = 1 is the light.
fn shadow_ray(o: Vec3, sample: &LightSample) -> Ray {
    match &sample.point {
        Some(point) => {
            let target = offset_origin(point.p, point.p_error, point.n, -sample.wi);
            Ray { o, d: target - o, t_max: END }
        }
        None if sample.distance.is_finite() => Ray { o, d: sample.wi, t_max: sample.distance },
        None => Ray::new(o, sample.wi),
    }
}
