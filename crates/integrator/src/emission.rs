//! What a ray picks up where it ends: radiance of the surface it hit or of the environment, weighted against the
//! light sampling that could have found the same place.

use crate::settings::Strategy;
use dapple_geometry::{Hit, Surface};
use dapple_lights::{Aiming, Light, Reached};
use dapple_math::Ray;
use dapple_sampling::mis;
use dapple_scene::Scene;
use glam::{Vec2, Vec3};

/// How a ray came to where it is: what aiming at lights from its origin needs to be weighed against.
#[derive(Clone, Copy)]
pub(crate) struct MisContext {
    /// Origin of the ray and the normal there, as given to the light choice.
    pub p: Vec3,
    pub n: Vec3,
    /// Solid-angle density of the direction, times the number of such rays.
    pub pdf: f32,
    pub competing: CompetingStrategy,
    /// Area lights are points at their centroids: what is met of their surfaces counts nothing.
    pub lights_are_points: bool,
    /// Seconds since the shutter opened: lights are weighed where they are then.
    pub time: f32,
    /// Mirrors and clear glass alone lie between the camera and here: what is shadeless shows. Elsewhere it lights nothing.
    pub is_seen: bool,
    /// How far the ray's origin is from `p`: the way has passed surfaces that let it go straight on, as a shadow ray does.
    pub gone: f32,
    /// The way has been bent, where shadow rays go straight on: they stand for what it would find.
    pub bent: bool,
    /// How far a camera ray still sees; not above 0 of rays that are none.
    pub view: f32,
}

/// What else could have found the light that a ray meets.
#[derive(Clone, Copy)]
pub(crate) enum CompetingStrategy {
    /// Nothing: camera rays and delta lobes.
    Nothing,
    /// One light chosen among all.
    Choice,
    /// Every light, with `points` points each.
    Each { points: f32, aiming: Aiming },
}

impl MisContext {
    pub const CAMERA: Self = Self {
        p: Vec3::ZERO,
        n: Vec3::ZERO,
        pdf: 1.0,
        competing: CompetingStrategy::Nothing,
        lights_are_points: false,
        time: 0.0,
        is_seen: true,
        gone: 0.0,
        bent: false,
        view: f32::INFINITY,
    };

    /// On through a smooth surface, `distance` farther, in the direction that it came if that is not bent.
    pub fn through(self, distance: f32, bent: bool) -> Self {
        let view = if bent { 0.0 } else { self.view - distance };
        Self { gone: self.gone + distance, bent: self.bent || bent, view, ..self }
    }

    /// Whether the ray is a camera ray.
    #[inline(always)]
    pub fn is_camera(&self) -> bool {
        self.view > 0.0
    }

    /// The ray, up to where the camera sees if it is a camera ray.
    #[inline(always)]
    pub fn ending(&self, ray: Ray) -> Ray {
        if self.is_camera() { ray.until(self.view / ray.d.length()) } else { ray }
    }
}

/// Radiance of the environment along `d`.
pub(crate) fn escaped(scene: &Scene, d: Vec3, arrival: &MisContext, strategy: Strategy) -> Vec3 {
    let Some(index) = scene.environment.filter(|_| cfg!(not(without = "environment"))) else {
        return Vec3::ZERO;
    };
    let Light::Environment(environment) = &scene.lights[index as usize] else { return Vec3::ZERO };
    let radiance = environment.radiance(d);
    if radiance == Vec3::ZERO {
        return radiance;
    }
    let reached = Reached { wi: d, distance: f32::INFINITY, n: Vec3::ZERO, at: Vec2::ZERO };
    radiance * bsdf_weight(scene, index, arrival, &reached, strategy)
}

/// Radiance of the surface that was hit, towards `wo`.
pub(crate) fn surface(
    scene: &Scene,
    hit: &Hit,
    surface: &Surface,
    wo: Vec3,
    distance: f32,
    arrival: &MisContext,
    strategy: Strategy,
) -> Vec3 {
    let radiance = scene.emission(hit, surface, wo);
    if radiance == Vec3::ZERO {
        return radiance;
    }
    match scene.light_of(hit) {
        Some(_) if arrival.lights_are_points => Vec3::ZERO,
        Some(light) => {
            let distance = distance + arrival.gone;
            let reached = Reached { wi: -wo, distance, n: surface.ng, at: Vec2::new(hit.u, hit.v) };
            radiance * bsdf_weight(scene, light, arrival, &reached, strategy)
        }
        None if !arrival.is_seen && scene.material(hit.object).unlit => Vec3::ZERO,
        None => radiance,
    }
}

/// Weight of the direction having been found by the BSDF.
fn bsdf_weight(
    scene: &Scene,
    light: u32,
    arrival: &MisContext,
    reached: &Reached,
    strategy: Strategy,
) -> f32 {
    let of = &scene.lights[light as usize];
    let pdf = match arrival.competing {
        _ if strategy == Strategy::BsdfOnly => return 1.0,
        CompetingStrategy::Nothing => return 1.0,
        CompetingStrategy::Choice => match &scene.light_choice {
            Some(choice) => {
                choice.pmf(arrival.p, arrival.n, light as usize)
                    * of.pdf_at(Aiming::SolidAngle, arrival.p, reached, arrival.time)
            }
            None => return 1.0,
        },
        CompetingStrategy::Each { points, aiming } => {
            points * of.pdf_at(aiming, arrival.p, reached, arrival.time)
        }
    };
    match strategy {
        _ if arrival.bent && pdf > 0.0 => 0.0,
        Strategy::LightOnly if pdf > 0.0 => 0.0,
        _ => mis::power(arrival.pdf, pdf),
    }
}
