//! Next-event estimation: light that falls directly on a vertex, found by aiming at a light.

use crate::settings::Strategy;
use crate::vertex::Vertex;
use crate::visibility::Visibility;
use dapple_geometry::{Ray, offset::offset_origin};
use dapple_lights::LightSample;
use dapple_materials::Lobes;
use dapple_sampling::{Key, mis};
use dapple_scene::Scene;
use glam::{Vec2, Vec3};

/// One attempt to find light: its numbers, and what its shadow ray passes through.
#[derive(Clone, Copy)]
pub(crate) struct Aim {
    /// Chooses the light.
    pub uc: f32,
    /// The point on it.
    pub u: Vec2,
    /// Seconds within the shutter.
    pub time: f32,
    /// Of the alpha that the shadow ray meets.
    pub key: Key,
    /// Absorption on the way, per render unit.
    pub sigma_a: Vec3,
    pub strategy: Strategy,
}

/// One light, one point on it: an estimate of ∫ f·L·|cosθ| dω over all lights. Counts its shadow ray in `rays`.
pub(crate) fn one<V: Visibility>(
    scene: &Scene,
    visibility: V,
    vertex: &Vertex,
    aim: &Aim,
    rays: &mut u64,
) -> Vec3 {
    let Some(choice) = &scene.light_choice else { return Vec3::ZERO };
    let p = vertex.surface.p;
    let Some(chosen) = choice.sample(p, vertex.choice_normal(), aim.uc) else { return Vec3::ZERO };
    let Some(sample) = scene.lights[chosen.index].sample(p, aim.u) else { return Vec3::ZERO };
    let (f_cos, bsdf_pdf) = vertex.f_cos_and_pdf(sample.wi, Lobes::ALL);
    if f_cos == Vec3::ZERO {
        return Vec3::ZERO;
    }
    let radiance = match &sample.point {
        Some(point) => scene.light_radiance(chosen.index as u32, point, sample.radiance),
        None => sample.radiance,
    };
    let pdf = sample.pdf * chosen.pmf;
    let weight = light_weight(&sample, pdf, bsdf_pdf, aim.strategy);
    let value = f_cos * radiance * (weight / pdf);
    if value == Vec3::ZERO || value.is_nan() {
        return value;
    }
    *rays += 1;
    if visibility.blocked(scene, &shadow_ray(vertex, &sample), aim.time, aim.key) {
        return Vec3::ZERO;
    }
    value * transmittance(aim.sigma_a, sample.distance)
}

fn light_weight(sample: &LightSample, pdf: f32, bsdf_pdf: f32, strategy: Strategy) -> f32 {
    match strategy {
        _ if sample.delta => 1.0,
        Strategy::Both => mis::power(pdf, bsdf_pdf),
        Strategy::LightOnly => 1.0,
        Strategy::BsdfOnly => 0.0,
    }
}

/// From outside the vertex' error box to outside the light's; t = 1 is the light.
fn shadow_ray(vertex: &Vertex, sample: &LightSample) -> Ray {
    let o = vertex.origin(sample.wi);
    match &sample.point {
        Some(point) => {
            let target = offset_origin(point.p, point.p_error, point.n, -sample.wi);
            Ray { o, d: target - o, t_max: 1.0 }
        }
        None if sample.distance.is_finite() => Ray { o, d: sample.wi, t_max: sample.distance },
        None => Ray::new(o, sample.wi),
    }
}

/// exp(−σ_a·s) per channel (Beer–Lambert); 1 without absorption whatever the distance.
pub(crate) fn transmittance(sigma_a: Vec3, distance: f32) -> Vec3 {
    if sigma_a == Vec3::ZERO {
        return Vec3::ONE;
    }
    let along = |s: f32| if s > 0.0 { libm::expf(-s * distance) } else { 1.0 };
    Vec3::new(along(sigma_a.x), along(sigma_a.y), along(sigma_a.z))
}
