//! The path tracer: the whole path is randomised, all integrals at once [Kajiya 1986].
//!
//! At every vertex: what the ray picked up, plus one light by next-event estimation, plus one direction by the BSDF.
//! Light and BSDF sampling are weighted by the power heuristic [Veach 1997, §9.2.2]. Roulette starts at the fourth
//! bounce and survives with min(1, max β·η²), without a cap below 1: a cap has infinite variance for bright
//! materials (measured law in the test suite).

use crate::direct::{self, Aim, transmittance};
use crate::emission::{self, Arrival};
use crate::sample::Sample;
use crate::settings::Settings;
use crate::vertex::Vertex;
use crate::visibility::Visibility;
use dapple_geometry::Ray;
use dapple_materials::{BsdfSample, Lobes};
use dapple_sampling::Dimension;
use dapple_scene::Scene;
use glam::Vec3;

/// Bounces before roulette begins.
const ROULETTE_FROM: u32 = 3;

/// Follows a path as it grows; the empty follower costs nothing.
pub(crate) trait Follow {
    fn vertex(&mut self, _depth: u32, _vertex: &Vertex, _beta: Vec3, _emitted: Vec3) {}
    fn direct(&mut self, _direct: Vec3) {}
    fn scattered(&mut self, _sample: &BsdfSample) {}
    fn escaped(&mut self, _beta: Vec3, _radiance: Vec3, _d: Vec3) {}
}

/// Nobody watches.
pub(crate) struct Unwatched;
impl Follow for Unwatched {}

/// Radiance along `ray` for one sample; counts rays.
pub(crate) fn li<V: Visibility, F: Follow>(
    scene: &Scene,
    settings: &Settings,
    visibility: V,
    ray: Ray,
    sample: &Sample,
    follow: &mut F,
    rays: &mut u64,
) -> Vec3 {
    let mut ray = ray;
    let mut state = PathState::default();
    let mut radiance = Vec3::ZERO;
    for depth in 0.. {
        *rays += 1;
        let key = sample.key.at(depth, Dimension::Alpha);
        let Some(hit) = visibility.closest(scene, &ray, sample.time, key.branch(sample.s)) else {
            let le = emission::escaped(scene, ray.d.normalize(), &state.arrival, settings.strategy);
            follow.escaped(state.beta, le, ray.d);
            return radiance + state.beta * le;
        };
        let surface = scene.world.surface(&ray, sample.time, &hit);
        let length = ray.d.length();
        let distance = hit.t * length;
        let wo = -ray.d / length;
        state.beta *= transmittance(state.sigma_a, distance);
        let le = emission::surface(scene, &hit, &surface, wo, distance, &state.arrival, settings.strategy);
        radiance += state.beta * le;
        let vertex = Vertex::new(scene, &ray, &hit, &surface, wo);
        follow.vertex(depth, &vertex, state.beta, le);
        if vertex.shading.unlit || depth >= settings.max_bounces {
            return radiance;
        }
        if !vertex.bsdf.is_delta() {
            let aim = Aim {
                uc: sample.point_1d(depth, Dimension::LightChoice),
                u: sample.point_2d(depth, Dimension::LightPoint),
                time: sample.time,
                key: sample.key.at(depth, Dimension::ShadowAlpha).branch(sample.s),
                sigma_a: state.sigma_a,
                strategy: settings.strategy,
            };
            let direct = direct::one(scene, visibility, &vertex, &aim, rays);
            follow.direct(direct);
            radiance += state.beta * direct;
        }
        let Some(next) = scatter(&vertex, sample, depth, follow, &mut state) else { return radiance };
        ray = next;
        if settings.roulette
            && depth >= ROULETTE_FROM
            && !state.survives(sample.point_1d(depth, Dimension::Roulette))
        {
            return radiance;
        }
    }
    radiance
}

/// What a path carries from vertex to vertex.
struct PathState {
    /// Product of f·cos/pdf so far.
    beta: Vec3,
    /// Undoes the radiance compression of refraction in the roulette.
    eta: f32,
    /// Absorption of what the path is in, per render unit.
    sigma_a: Vec3,
    arrival: Arrival,
}

impl Default for PathState {
    fn default() -> Self {
        Self { beta: Vec3::ONE, eta: 1.0, sigma_a: Vec3::ZERO, arrival: Arrival::CAMERA }
    }
}

impl PathState {
    fn survives(&mut self, u: f32) -> bool {
        let q = (self.beta * self.eta).max_element().min(1.0);
        if u >= q {
            return false;
        }
        self.beta /= q;
        true
    }
}

/// Chooses the next direction; None when the path carries nothing on.
fn scatter<F: Follow>(
    vertex: &Vertex,
    sample: &Sample,
    depth: u32,
    follow: &mut F,
    state: &mut PathState,
) -> Option<Ray> {
    let uc = sample.point_1d(depth, Dimension::Lobe);
    let u = sample.point_2d(depth, Dimension::Direction);
    let scattered = vertex.bsdf.sample_f(uc, u, Lobes::ALL)?;
    follow.scattered(&scattered);
    let wi = vertex.frame.to_world(scattered.wi).normalize();
    if scattered.weight == Vec3::ZERO || !vertex.sides_agree(wi, scattered.wi) {
        return None;
    }
    state.beta *= scattered.weight;
    state.eta *= scattered.eta;
    state.arrival = Arrival {
        p: vertex.surface.p,
        n: vertex.choice_normal(),
        pdf: scattered.pdf,
        delta: scattered.lobe.is_delta(),
    };
    if scattered.lobe.is_transmission() && !vertex.shading.material.thin {
        state.sigma_a = if wi.dot(vertex.surface.ng) < 0.0 { vertex.shading.sigma_a } else { Vec3::ZERO };
    }
    Some(Ray::new(vertex.origin(wi), wi))
}
