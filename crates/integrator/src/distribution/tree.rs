//! The ray tree of one camera ray: sums over lights and lobes at every vertex.

use super::branch::{Branch, DEEP};
use crate::Dimension;
use crate::bias_report::{FAINT, Truncation};
use crate::direct::{DirectLighting, Sides};
use crate::effects::{Effect, SampleSets};
use crate::emission::{self, CompetingStrategy, MisContext};
use crate::first_hit::{start, visible_hit};
use crate::interface::meet;
use crate::job::Job;
use crate::medium::{Boundary, MediumStack};
use crate::observer::{PathObserver, cut_short};
use crate::places::Place;
use crate::scatter::Scattered;
use crate::shared_place;
use crate::trace_context::TraceContext;
use crate::vertex::Vertex;
use crate::visibility::Visibility;
use dapple_geometry::{Hit, Surface};
use dapple_lights::{Aiming, Light, LightSample};
use dapple_materials::{Lobe, Lobes};
use dapple_math::Ray;
use dapple_sampling::{Key, Pattern, SampleSet};
use glam::Vec3;
use std::cell::Cell;

/// Lobe groups that form one integral each, and the effect with their sample set unless the lobe is smooth.
const GROUPS: [(Lobes, Effect); 3] = [
    (Lobes::of(Lobe::Diffuse), Effect::Diffuse),
    (Lobes::REFLECTION, Effect::Glossy),
    (Lobes::TRANSMISSION, Effect::Refract),
];

/// A single sample, for integrals whose points all coincide.
const ONE: SampleSet = SampleSet { nx: 1, ny: 1, pattern: Pattern::Grid };

/// The ray tree of one camera ray.
pub(super) struct Tree<'a, V, O> {
    pub job: &'a Job<'a>,
    pub visibility: V,
    /// Seconds since the shutter opened, the same for the whole tree.
    pub time: f32,
    pub observer: &'a mut O,
    pub rays: &'a mut u64,
    /// The next ray to trace from the last deep vertex, see `deep.rs`.
    pub held: Option<Branch>,
    /// Number of nested branches of deep vertices in progress.
    pub nested: u32,
    /// Upper bound of the ray parameter of the near plane along the camera ray.
    pub near: f32,
}

/// End of a ray of the tree.
struct Arrived {
    /// The surface, and its boundary between media if it has one; `None` where the ray leaves the scene.
    at: Option<(Hit, Surface, Option<Boundary>)>,
    /// Length of the ray.
    distance: f32,
    /// Transmittance of the media along the ray.
    transmittance: Vec3,
    /// The media in front of the surface, if the scene has media.
    stack: Option<MediumStack>,
    /// A body was dropped from a full medium stack.
    overflows: bool,
}

impl Default for Arrived {
    fn default() -> Self {
        Self { at: None, distance: 0.0, transmittance: Vec3::ONE, stack: None, overflows: false }
    }
}

impl<'a, V: Visibility, O: PathObserver> Tree<'a, V, O> {
    /// Radiance along `ray`, which arrives at `place`; `beta` is its throughput from the pixel sample, for the
    /// observer.
    pub fn li(
        &mut self,
        ray: &Ray,
        arrival: &MisContext,
        place: Place,
        stack: &MediumStack,
        beta: Vec3,
    ) -> Vec3 {
        if self.job.is_stopped() {
            return Vec3::ZERO;
        }
        *self.rays += 1;
        let (scene, settings) = (self.job.scene, self.job.settings);
        let key = place.ray_key(Dimension::Alpha, 0, 0);
        let length = ray.d.length();
        let arrived = match V::PLAIN || self.job.media.is_empty() {
            true => self.arrive(ray, arrival, place, key),
            false => self.arrive_through_media(ray, arrival, (place, stack), key),
        };
        let Arrived { at, distance, transmittance: absorbed, stack: inner, overflows } = arrived;
        if overflows {
            self.observer.cut(Truncation::Nested, beta * absorbed);
        }
        let Some((hit, surface, boundary)) = at else {
            return absorbed * self.escaped(ray, arrival, place, beta * absorbed);
        };
        let (near, boundary) = (inner.as_ref().unwrap_or(stack), boundary.as_ref());
        let wo = -ray.d / length;
        let beta = beta * absorbed;
        let le = emission::surface(scene, &hit, &surface, wo, distance, arrival, settings.strategy);
        let vertex = Vertex::new(self.job, (ray, wo), (&hit, &surface), (self.time, boundary));
        self.observer.vertex(place.depth, &vertex, beta, le);
        if vertex.shading.unlit || place.depth >= self.job.bounces {
            cut_short(&vertex, beta, self.observer);
            return absorbed * le;
        }
        if beta.max_element() < FAINT {
            self.observer.cut(Truncation::Faint, beta);
            return absorbed * le;
        }
        let media = Sides { near, far: boundary.map_or(near, |boundary| &boundary.after) };
        let direct = self.direct(&vertex, place, media, beta);
        self.observer.direct(direct);
        let scattered = self.scattered(&vertex, place, media, (arrival, distance), beta);
        if let Some(held) = self.held.as_mut() {
            held.factor *= absorbed;
        }
        absorbed * (le + direct + scattered)
    }

    /// The nearest surface, in a scene without media.
    #[inline(always)]
    fn arrive(&self, ray: &Ray, arrival: &MisContext, place: Place, key: Key) -> Arrived {
        let scene = self.job.scene;
        let nothing = Arrived::default();
        let Some(mut hit) = self.visibility.intersect(scene, ray, self.time, key) else { return nothing };
        let mut surface = scene.accel.surface(ray, self.time, &hit);
        if let Some(places) = shared_place::of(scene).filter(|_| !V::PLAIN) {
            shared_place::resolve_shared(places, ray, (&mut hit, &mut surface), &self.context(key));
        }
        let mut distance = hit.t * ray.d.length();
        let is_camera = if V::PLAIN { place.depth == 0 } else { arrival.is_camera() };
        let clip = self.clip(place);
        if is_camera && self.job.passes(ray, (&hit, &surface), clip, self.time) {
            let Some(shown) = visible_hit(&self.context(key), ray, (clip, hit.t)) else { return nothing };
            (hit, surface, distance) = shown;
        }
        Arrived { at: Some((hit, surface, None)), distance, ..nothing }
    }

    /// As [`arrive`](Self::arrive), through the media along the ray.
    fn arrive_through_media(
        &self,
        ray: &Ray,
        arrival: &MisContext,
        (place, stack): (Place, &MediumStack),
        key: Key,
    ) -> Arrived {
        let mut met = meet(&self.context(key), ray, stack, None);
        let is_clipped = self.job.clips(met.first, self.clip(place), ray, self.time);
        if arrival.is_camera() && (is_clipped || met.is_passed(self.job, ray, self.time)) {
            let again = if is_clipped { start(self.job, ray, self.time) } else { (*ray, *stack, 0.0) };
            met = meet(&self.context(key).of_camera_ray(), &again.0, &again.1, None);
            met.distance += again.2;
        }
        Arrived {
            at: met.at,
            distance: met.distance,
            transmittance: met.transmittance,
            stack: Some(met.stack),
            overflows: met.overflows,
        }
    }

    /// Upper bound of the ray parameter of the near plane along a camera ray; 0 for other rays.
    fn clip(&self, place: Place) -> f32 {
        if place.depth == 0 { self.near } else { 0.0 }
    }

    /// Radiance of the environment along a ray that leaves the scene.
    fn escaped(&mut self, ray: &Ray, arrival: &MisContext, place: Place, beta: Vec3) -> Vec3 {
        let strategy = self.job.settings.strategy;
        let le = match place.depth == 0 && self.observer.hides_backdrop() {
            true => Vec3::ZERO,
            false => emission::escaped(self.job.scene, ray.d.normalize(), arrival, strategy),
        };
        self.observer.escaped(place.depth, beta, le, ray.d);
        le
    }

    /// Direct light at the vertex: the sum over lights of the mean over each.
    fn direct(&mut self, vertex: &Vertex, place: Place, media: Sides<'_>, beta: Vec3) -> Vec3 {
        if vertex.bsdf.is_delta() {
            return Vec3::ZERO;
        }
        let (plans, lights) = (self.job.integrals.at(place.depth), self.job.scene.lights.iter());
        let mut sum: Vec3 =
            (0..).zip(lights).map(|(i, light)| self.light_mean(vertex, place, media, (i, light), beta)).sum();
        if plans.is_off(Effect::Diffuse) {
            sum += self.sky_mean(vertex, place, media, beta);
            sum += vertex.bsdf.diffuse_albedo() * self.job.settings.ambient;
        }
        sum
    }

    /// Environment light on a diffuse lobe that is not sampled: the mean over cosine-distributed directions, as many as
    /// light samples of the environment.
    fn sky_mean(&mut self, vertex: &Vertex, place: Place, media: Sides<'_>, beta: Vec3) -> Vec3 {
        if self.job.scene.environment.is_none() || !vertex.bsdf.lobes().contains(Lobe::Diffuse) {
            return Vec3::ZERO;
        }
        let integrals = &self.job.integrals;
        let plan = integrals.sky(&place);
        let place = self.first_again(place, Effect::Light);
        let n = place.count(plan);
        let aimed = |light: usize, pdf: f32| {
            let plans = integrals.at(place.depth);
            place.count(light_plan(&self.job.scene.lights[light], plans, || plan)) as f32 * pdf
        };
        let mut sum = Vec3::ZERO;
        for s in 0..n {
            if self.job.is_stopped() {
                break;
            }
            let u = place.point_2d(plan, Dimension::Sky, 0, s);
            let beam = self.beam(vertex, place.ray_key(Dimension::Sky, 0, s), media, place);
            sum += beam.sky_on_diffuse(u, n as f32, aimed, self.rays);
            if !V::PLAIN && !self.job.plain_shadows {
                beam.report_lost(beta / n as f32, self.observer);
            }
        }
        sum / n.max(1) as f32
    }

    /// Mean over the points of light `i`.
    fn light_mean(
        &mut self,
        vertex: &Vertex,
        place: Place,
        media: Sides<'_>,
        (i, light): (u32, &Light),
        beta: Vec3,
    ) -> Vec3 {
        let plans = self.job.integrals.at(place.depth);
        let plan = light_plan(light, plans, || self.job.integrals.sky(&place));
        let aiming = aiming(light, plans);
        let place = self.first_again(place, Effect::Light);
        let n = place.count(plan);
        let mut sum = Vec3::ZERO;
        for s in 0..n {
            if self.job.is_stopped() {
                break;
            }
            let u = place.point_2d(plan, Dimension::LightPoint, i, s);
            let Some(sample) = light.sample_as(aiming, vertex.surface.p, u, self.time) else { continue };
            let beam = self.beam(vertex, place.ray_key(Dimension::ShadowAlpha, i, s), media, place);
            let f_cos = Self::received(&beam, place, light, &sample, (n as f32, false));
            let alone = || Self::received_alone(&beam, place, light, &sample, n as f32);
            sum += beam.arriving(i as usize, &sample, sample.pdf, (f_cos, alone), self.rays);
            if !V::PLAIN && !self.job.plain_shadows {
                beam.report_lost(beta / n as f32, self.observer);
            }
        }
        sum / n.max(1) as f32
    }

    fn beam<'v>(&self, vertex: &'v Vertex, key: Key, media: Sides<'v>, place: Place) -> DirectLighting<'v, V>
    where
        'a: 'v,
    {
        let (strategy, reach) = (self.job.settings.strategy, self.job.bounces - place.depth - 1);
        DirectLighting {
            context: self.context(key),
            vertex,
            media,
            strategy,
            reach,
            lost: Cell::new(Vec3::ZERO),
        }
    }

    fn context(&self, key: Key) -> TraceContext<'a, V> {
        TraceContext {
            job: self.job,
            scene: self.job.scene,
            visibility: self.visibility,
            time: self.time,
            key,
        }
    }

    /// f·cosθ for one of `n` samples of a light, each lobe weighted against its BSDF samples unless the samples are
    /// `alone`.
    #[inline(always)]
    fn received(
        beam: &DirectLighting<'_, V>,
        place: Place,
        light: &Light,
        sample: &LightSample,
        (n, alone): (f32, bool),
    ) -> Vec3 {
        let plans = beam.context.job.integrals.at(place.depth);
        let live = beam.vertex.bsdf.lobes().without(Lobes::DELTA);
        let mut sum = Vec3::ZERO;
        for (lobes, effect) in GROUPS {
            if live.and(lobes).is_empty() {
                continue;
            }
            let (f_cos, pdf) = beam.vertex.f_cos_and_pdf(sample.wi, lobes);
            // A diffuse lobe that is not sampled still samples the environment.
            let followed = match place.count(plans.of(effect)) {
                0 if matches!(light, Light::Environment(_)) => {
                    place.count(beam.context.job.integrals.sky(&place))
                }
                _ if alone => 0,
                count => count,
            };
            sum += f_cos * beam.weight(sample.delta, n * sample.pdf, followed as f32 * pdf);
        }
        sum
    }

    /// As [`Self::received`], for light samples without competing BSDF samples.
    #[cold]
    #[inline(never)]
    fn received_alone(
        beam: &DirectLighting<'_, V>,
        place: Place,
        light: &Light,
        sample: &LightSample,
        n: f32,
    ) -> Vec3 {
        Self::received(beam, place, light, sample, (n, true))
    }

    /// Indirect light: the sum over lobes of the mean over the directions of each.
    fn scattered(
        &mut self,
        vertex: &Vertex,
        place: Place,
        media: Sides<'_>,
        came: (&MisContext, f32),
        beta: Vec3,
    ) -> Vec3 {
        let live = vertex.bsdf.lobes();
        let mut sum = Vec3::ZERO;
        for (which, (lobes, effect)) in (0..).zip(GROUPS) {
            let lobes = live.and(lobes);
            if lobes.is_empty() {
                continue;
            }
            let mut plan = self.job.integrals.at(place.depth).of(effect);
            let smooth = lobes.without(Lobes::DELTA).is_empty();
            if smooth {
                plan = ONE;
            }
            let n = place.count(plan);
            let place = self.first_again(place, effect);
            let mut mean = Vec3::ZERO;
            let context = self.context(place.ray_key(Dimension::Alpha, 0, 0));
            for s in 0..n {
                if self.job.is_stopped() {
                    break;
                }
                let u = place.point_2d(plan, Dimension::Direction, which, s);
                let Some(scattered) = vertex.scatter(0.5, u, lobes, &context) else { continue };
                self.observer.scattered(place.depth, &scattered.sample);
                let mut arrival = if self.job.is_shadow_way(&scattered.sample) {
                    came.0.through(came.1, scattered.sample.eta != 1.0)
                } else {
                    self.arrival(vertex, &scattered, n as f32, place)
                };
                arrival.is_seen &= came.0.is_seen;
                let stack = if scattered.sample.lobe.is_transmission() { media.far } else { media.near };
                let (weight, ray) = (scattered.sample.weight, arrival.ending(scattered.ray));
                let beta = beta * weight / n as f32;
                let place = place.next(which, s, smooth);
                if place.depth >= DEEP {
                    let factor = weight / n as f32;
                    sum += self.deeper(Branch { ray, arrival, place, stack: *stack, beta, factor });
                    continue;
                }
                mean += weight * self.li(&ray, &arrival, place, stack, beta);
            }
            sum += mean / n.max(1) as f32;
        }
        sum
    }

    /// The place, with a different key if the points of `effect` at the first hit are drawn anew.
    fn first_again(&self, place: Place, effect: Effect) -> Place {
        if place.depth == 0 { place.again(effect, self.job.again) } else { place }
    }

    /// MIS context of one of `n` rays that leave the vertex by the same lobe.
    fn arrival(&self, vertex: &Vertex, scattered: &Scattered, n: f32, place: Place) -> MisContext {
        let plans = self.job.integrals.at(place.depth);
        let off = plans.is_off(Effect::Light);
        // If the light integral is off, only the environment is sampled.
        let points = place.count(self.job.integrals.sky(&place)) as f32;
        let on_grid = plans.light.pattern == Pattern::Grid;
        let aiming = if on_grid { Aiming::Surface } else { Aiming::SolidAngle };
        let delta = scattered.sample.lobe.is_delta();
        MisContext {
            p: vertex.surface.p,
            n: vertex.choice_normal(),
            pdf: n * scattered.sample.pdf,
            competing: if delta {
                CompetingStrategy::Nothing
            } else {
                CompetingStrategy::Each { points, aiming }
            },
            lights_are_points: off,
            time: self.time,
            is_seen: delta,
            gone: 0.0,
            bent: false,
            view: 0.0,
        }
    }
}

/// Sample set of a light: one sample where all coincide, none for an environment that BSDF sampling covers, `sky` for
/// other environments.
pub(crate) fn light_plan(light: &Light, plans: &SampleSets, sky: impl Fn() -> SampleSet) -> SampleSet {
    match light {
        Light::Environment(e) if !e.is_sampled() => SampleSet::OFF,
        // Switching off the light integral does not affect the environment.
        Light::Environment(_) => sky(),
        light if light.is_delta() || (light.is_area() && plans.is_off(Effect::Light)) => ONE,
        _ => plans.light,
    }
}

/// A grid treats an area light as a set of point lights; other patterns sample the solid angle, which has the least
/// variance.
fn aiming(light: &Light, plans: &SampleSets) -> Aiming {
    match plans.light.pattern {
        _ if !light.is_area() => Aiming::SolidAngle,
        _ if plans.is_off(Effect::Light) => Aiming::Centroid,
        Pattern::Grid => Aiming::Surface,
        _ => Aiming::SolidAngle,
    }
}
