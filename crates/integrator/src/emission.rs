//! Emission found by rays: radiance of the surface that is hit or of the environment, weighted against the light
//! sampling that could have found the same point.

use crate::settings::Strategy;
use dapple_geometry::{Hit, Surface};
use dapple_lights::{Aiming, Light, Reached};
use dapple_math::Ray;
use dapple_math::lanes::Real;
use dapple_sampling::lanes;
use dapple_scene::Scene;
use glam::{Vec2, Vec3};

/// State of a ray that the MIS weight of the emission at its end depends on.
#[derive(Clone, Copy)]
pub(crate) struct MisContext {
    /// Origin of the ray and the normal there, as passed to the light choice.
    pub p: Vec3,
    pub n: Vec3,
    /// Solid-angle density of the direction, times the number of such rays.
    pub pdf: f32,
    pub competing: CompetingStrategy,
    /// Area lights are points at their centroids: hits of their surfaces contribute nothing.
    pub lights_are_points: bool,
    /// Seconds since the shutter opened: densities of light sampling use the lights at this time.
    pub time: f32,
    /// The path from the camera consists only of specular reflection and specular transmission, so that unlit surfaces
    /// are visible. For other paths, unlit surfaces emit nothing.
    pub is_seen: bool,
    /// Distance from `p` to the ray origin: the path has passed surfaces straight through, as a shadow ray does.
    pub gone: f32,
    /// The path was refracted where shadow rays pass straight through; shadow rays account for the light that it would
    /// find.
    pub bent: bool,
    /// Remaining visible distance of a camera ray; not positive for other rays.
    pub view: f32,
}

/// Light sampling that competes with a ray that hits a light.
#[derive(Clone, Copy)]
pub(crate) enum CompetingStrategy {
    /// None: camera rays and delta lobes.
    Nothing,
    /// One light, chosen among all.
    Choice,
    /// Every light, with `points` samples each.
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

    /// Continues through a smooth surface, `distance` farther, in the same direction unless `bent`.
    pub fn through(self, distance: f32, bent: bool) -> Self {
        let view = if bent { 0.0 } else { self.view - distance };
        Self { gone: self.gone + distance, bent: self.bent || bent, view, ..self }
    }

    /// Whether the ray is a camera ray.
    #[inline(always)]
    pub fn is_camera(&self) -> bool {
        self.view > 0.0
    }

    /// The ray, limited to the remaining visible distance if it is a camera ray.
    #[inline(always)]
    pub fn ending(&self, ray: Ray) -> Ray {
        if self.is_camera() { ray.until(self.view / ray.d.length()) } else { ray }
    }
}

/// Weighted radiance of the environment along `d`.
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

/// Weighted emission of the surface that was hit, towards `wo`.
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

/// MIS weight of a direction found by BSDF sampling.
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
    if arrival.bent && pdf > 0.0 { 0.0 } else { found_weight::<f32>(strategy, arrival.pdf, pdf) }
}

/// MIS weight of directions that BSDF sampling found with density `pdf`, and light sampling finds with density `light`.
#[inline(always)]
pub(crate) fn found_weight<R: Real>(strategy: Strategy, pdf: R, light: R) -> R {
    let (zero, weight) = (R::splat(0.0), lanes::mis::power(pdf, light));
    match strategy {
        Strategy::Both => weight,
        Strategy::LightOnly => R::select(light.gt(zero), zero, weight),
        Strategy::BsdfOnly => R::splat(1.0),
    }
}
