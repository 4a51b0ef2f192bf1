//! The path tracer: all integrals of a pixel are estimated by random paths [Kajiya 1986].
//!
//! Every vertex adds the emission that the ray hits and the direct light of one light by next-event estimation, and
//! samples one direction of the BSDF. Light and BSDF sampling are weighted by the power heuristic [Veach 1997, §9.2.2].
//! Russian roulette starts at the fourth bounce with the survival probability min(1, max β·η²), without a cap below 1:
//! a cap has infinite variance for bright materials (measured in the test suite).

use crate::Dimension;
use crate::bias_report::{FAINT, Truncation};
use crate::direct::{DirectLighting, DirectSample, Sides};
use crate::emission::{self, CompetingStrategy, MisContext};
use crate::first_hit::{start, visible_hit};
use crate::interface::meet;
use crate::job::Job;
use crate::medium::{Boundary, MediumStack};
use crate::observer::{PathObserver, cut_short};
use crate::sample::Sample;
use crate::scatter::Scattered;
use crate::settings::{ROULETTE_FROM, ROULETTE_SCALE, Strategy};
use crate::shared_place;
use crate::trace_context::TraceContext;
use crate::vertex::Vertex;
use crate::visibility::Visibility;
use dapple_geometry::{Hit, Surface};
use dapple_math::Ray;
use dapple_math::lanes::{Real, Vec3x};
use dapple_scene::Scene;
use glam::{Vec2, Vec3};
use std::cell::Cell;

/// Number of bounces between two checks of the stop flag.
const STOP_CHECK_INTERVAL: u32 = 256;

/// One path: its radiance and its filter weight.
#[inline(always)]
pub(crate) fn path_sample<V: Visibility, O: PathObserver>(
    job: &Job<'_>,
    visibility: V,
    pixel: (u32, u32),
    index: u32,
    observer: &mut O,
    rays: &mut u64,
) -> (Vec3, f32) {
    let sample = Sample::new(job.settings, pixel, index).timed(job);
    let (ray, weight) = sample.camera_ray(job, pixel);
    (li(job, visibility, ray, &sample, observer, rays), weight)
}

/// Radiance along `ray` for one sample; counts rays.
#[inline(always)]
fn li<V: Visibility, O: PathObserver>(
    job: &Job<'_>,
    visibility: V,
    ray: Ray,
    sample: &Sample,
    observer: &mut O,
    rays: &mut u64,
) -> Vec3 {
    // The near plane applies only to the camera ray.
    let (mut state, mut ray, mut near) = PathState::begin::<V>(job, ray, sample.time);
    for depth in 0.. {
        // The tile checks the flag after every sample; long paths also check it here.
        if depth % STOP_CHECK_INTERVAL == STOP_CHECK_INTERVAL - 1 && job.is_stopped() {
            break;
        }
        *rays += 1;
        let key = sample.alpha_key(depth, Dimension::Alpha);
        let context = TraceContext { job, scene: job.scene, visibility, time: sample.time, key };
        let way = (&mut ray, near, None);
        let Some(next) = state.step(&context, way, sample, depth, observer, rays) else { break };
        (ray, near) = (next, 0.0);
    }
    state.radiance
}

/// The unit direction that points back along a ray of direction `d`.
#[inline(always)]
pub(crate) fn away(d: Vec3) -> Vec3 {
    backward::<f32>(d.into()).0.into()
}

/// The unit directions that point back along rays of directions `d`, and the lengths of `d`.
#[inline(always)]
pub(crate) fn backward<R: Real>(d: Vec3x<R>) -> (Vec3x<R>, R) {
    let length = d.length();
    (-d / length, length)
}

/// One light by next-event estimation; without interreflection, also the environment on diffuse lobes and the ambient
/// light.
#[allow(clippy::too_many_arguments)]
pub(crate) fn direct<V: Visibility, O: PathObserver>(
    job: &Job<'_>,
    visibility: V,
    vertex: &Vertex,
    sample: &Sample,
    depth: u32,
    media: Sides<'_>,
    (beta, observer): (Vec3, &mut O),
    rays: &mut u64,
) -> Vec3 {
    if vertex.bsdf.is_delta() {
        return Vec3::ZERO;
    }
    let (scene, strategy) = (job.scene, job.settings.strategy);
    let key = sample.alpha_key(depth, Dimension::ShadowAlpha);
    let context = TraceContext { job, scene, visibility, time: sample.time, key };
    let reach = job.bounces - depth - 1;
    let beam = DirectLighting { context, vertex, media, strategy, reach, lost: Cell::new(Vec3::ZERO) };
    let mut sum = Vec3::ZERO;
    if job.needs.next_event {
        let aim = DirectSample {
            uc: if job.needs.light_choice { sample.point_1d(depth, Dimension::Light) } else { 0.0 },
            u: if job.needs.light_point { sample.point_2d(depth, Dimension::LightPoint) } else { Vec2::ZERO },
            aiming: job.aiming,
            followed: job.followed,
        };
        sum = beam.one(&aim, rays);
    }
    if job.has_no_interreflection() {
        let u = sample.point_2d(depth, Dimension::Sky);
        let (p, n) = (vertex.surface.p, vertex.choice_normal());
        let pmf = |light| scene.light_choice.as_ref().map_or(0.0, |choice| choice.pmf(p, n, light));
        sum += beam.sky_on_diffuse(u, 1.0, |light, pdf| pdf * pmf(light), rays);
        sum += vertex.bsdf.diffuse_albedo() * job.settings.ambient;
    }
    if !V::PLAIN && !job.plain_shadows {
        beam.report_lost(beta, observer);
    }
    sum
}

/// End of a ray of a path.
pub(crate) struct Place {
    pub hit: Hit,
    pub surface: Surface,
    /// Length of the ray.
    pub distance: f32,
    /// The media on both sides, if the surface separates two.
    pub boundary: Option<Boundary>,
}

impl Place {
    /// Weighted emission towards `wo`.
    #[inline(always)]
    pub fn emission(&self, scene: &Scene, wo: Vec3, arrival: &MisContext, strategy: Strategy) -> Vec3 {
        emission::surface(scene, &self.hit, &self.surface, wo, self.distance, arrival, strategy)
    }
}

/// What a path needs of the end of its ray when it continues: the length of the ray, and the media on both sides.
#[derive(Clone, Copy)]
pub(crate) struct End<'a> {
    pub distance: f32,
    pub boundary: Option<&'a Boundary>,
}

/// The nearest hit of a ray, and its surface, if that is known too.
pub(crate) type Known = (Hit, Option<Surface>);

/// State of a path between vertices.
pub(crate) struct PathState {
    /// Radiance found so far.
    pub radiance: Vec3,
    /// Product of f·cos/pdf so far.
    pub beta: Vec3,
    /// Product of the relative indices of refraction, which cancels the radiance compression of refraction in the
    /// roulette.
    pub eta: f32,
    /// The bodies that contain the path.
    pub stack: MediumStack,
    pub arrival: MisContext,
}

impl Default for PathState {
    fn default() -> Self {
        let (radiance, stack) = (Vec3::ZERO, MediumStack::EMPTY);
        Self { radiance, beta: Vec3::ONE, eta: 1.0, stack, arrival: MisContext::CAMERA }
    }
}

impl PathState {
    /// State at the start of a camera ray, which may be moved to the near plane: the state, the ray, and an upper bound
    /// of the ray parameter of the near plane.
    #[inline(always)]
    pub fn begin<V: Visibility>(job: &Job<'_>, mut ray: Ray, time: f32) -> (Self, Ray, f32) {
        let mut near = job.near_most;
        let mut state = Self::default();
        if !V::PLAIN && !job.media.is_empty() {
            state.stack = job.media.at(job.scene, &ray, time);
            if near > 0.0 && !state.stack.is_empty() {
                (ray, state.stack, _) = start(job, &ray, time);
                near = 0.0;
            }
        }
        if !V::PLAIN && ray.t_max < f32::INFINITY {
            state.arrival.view = ray.t_max * ray.d.length();
        }
        (state, ray, near)
    }

    /// Follows a path along its ray to the next vertex and scatters it there: the next ray, or `None` where the path
    /// ends. The nearest hit of the ray may be known.
    #[inline(always)]
    pub fn step<V: Visibility, O: PathObserver>(
        &mut self,
        context: &TraceContext<'_, V>,
        (ray, near, known): (&mut Ray, f32, Option<Known>),
        sample: &Sample,
        depth: u32,
        observer: &mut O,
        rays: &mut u64,
    ) -> Option<Ray> {
        let job = context.job;
        let has_media = !V::PLAIN && !job.media.is_empty();
        let arrived = match has_media {
            true => self.arrive_through_media(context, ray, (near, known), observer),
            false => self.arrive(context, ray, (near, known), depth),
        };
        let Some(place) = arrived else {
            self.escape(job, depth, ray.d, observer);
            return None;
        };
        let wo = away(ray.d);
        let le = place.emission(job.scene, wo, &self.arrival, job.settings.strategy);
        self.radiance += self.beta * le;
        let at = (&place.hit, &place.surface);
        let vertex = Vertex::new(job, (ray, wo), at, (sample.time, place.boundary.as_ref()));
        observer.vertex(depth, &vertex, self.beta, le);
        if vertex.shading.unlit || depth >= job.bounces {
            cut_short(&vertex, self.beta, observer);
            return None;
        }
        let end = End { distance: place.distance, boundary: place.boundary.as_ref() };
        self.leave(context, &vertex, end, sample, depth, observer, rays)
    }

    /// Adds the environment to a path that leaves the scene along `d`.
    #[inline(always)]
    pub fn escape<O: PathObserver>(&mut self, job: &Job<'_>, depth: u32, d: Vec3, observer: &mut O) {
        let le = match depth == 0 && observer.hides_backdrop() {
            true => Vec3::ZERO,
            false => emission::escaped(job.scene, d.normalize(), &self.arrival, job.settings.strategy),
        };
        observer.escaped(depth, self.beta, le, d);
        self.radiance += self.beta * le;
    }

    /// Adds the direct light at a vertex, and scatters the path: the next ray, or `None` where the path ends.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub fn leave<V: Visibility, O: PathObserver>(
        &mut self,
        context: &TraceContext<'_, V>,
        vertex: &Vertex,
        end: End<'_>,
        sample: &Sample,
        depth: u32,
        observer: &mut O,
        rays: &mut u64,
    ) -> Option<Ray> {
        let job = context.job;
        let near = &self.stack;
        let media = Sides { near, far: end.boundary.map_or(near, |boundary| &boundary.after) };
        let lit = (self.beta, &mut *observer);
        let direct = direct(job, context.visibility, vertex, sample, depth, media, lit, rays);
        observer.direct(direct);
        self.radiance += self.beta * direct;
        let uc = if job.needs.lobe { sample.point_1d(depth, Dimension::Lobe) } else { 0.0 };
        let u = if job.needs.direction { sample.point_2d(depth, Dimension::Direction) } else { Vec2::ZERO };
        let next = vertex.scatter(uc, u, job.followed, context)?;
        observer.scattered(depth, &next.sample);
        self.advance(job, vertex, &next, sample.time, end.distance);
        if let (true, Some(boundary)) = (!V::PLAIN && next.sample.lobe.is_transmission(), end.boundary) {
            self.stack = boundary.after;
        }
        if is_faint::<f32>(self.beta.into()) {
            observer.cut(Truncation::Faint, self.beta);
            return None;
        }
        let plays = depth >= ROULETTE_FROM && job.roulette;
        if plays && !self.survives(sample.point_1d(depth, Dimension::Roulette)) {
            return None;
        }
        Some(if V::PLAIN { next.ray } else { self.arrival.ending(next.ray) })
    }

    /// The nearest surface, in a scene without media. Camera rays ignore surfaces in front of the near plane, at
    /// `near`.
    #[inline(always)]
    fn arrive<V: Visibility>(
        &self,
        context: &TraceContext<'_, V>,
        ray: &Ray,
        (near, known): (f32, Option<Known>),
        depth: u32,
    ) -> Option<Place> {
        let (hit, surface) = match known {
            Some(known) => known,
            None => (context.visibility.intersect(context.scene, ray, context.time, context.key)?, None),
        };
        let is_camera = if V::PLAIN { depth == 0 } else { self.arrival.is_camera() };
        let surface = surface.unwrap_or_else(|| context.scene.accel.surface(ray, context.time, &hit));
        Self::place(context, ray, (hit, surface), near, is_camera)
    }

    /// The place of the nearest hit, or behind the surfaces that a camera ray passes.
    #[inline(always)]
    pub fn place<V: Visibility>(
        context: &TraceContext<'_, V>,
        ray: &Ray,
        (mut hit, mut surface): (Hit, Surface),
        near: f32,
        is_camera: bool,
    ) -> Option<Place> {
        let (job, scene, time) = (context.job, context.scene, context.time);
        if let Some(places) = shared_place::of(scene).filter(|_| !V::PLAIN) {
            shared_place::resolve_shared(places, ray, (&mut hit, &mut surface), context);
        }
        let mut distance = hit.t * ray.d.length();
        if is_camera && job.passes(ray, (&hit, &surface), near, time) {
            (hit, surface, distance) = visible_hit(context, ray, (near, hit.t))?;
        }
        Some(Place { hit, surface, distance, boundary: None })
    }

    /// As [`arrive`](Self::arrive), through the media along the ray, which the path leaves and enters.
    #[inline(always)]
    fn arrive_through_media<V: Visibility, O: PathObserver>(
        &mut self,
        context: &TraceContext<'_, V>,
        ray: &mut Ray,
        (near, known): (f32, Option<Known>),
        observer: &mut O,
    ) -> Option<Place> {
        let (job, time) = (context.job, context.time);
        let mut met = meet(context, ray, &self.stack, known);
        let is_clipped = job.clips(met.first, near, ray, time);
        if self.arrival.is_camera() && (is_clipped || met.is_passed(job, ray, time)) {
            let mut before = 0.0;
            if is_clipped {
                (*ray, self.stack, before) = start(job, ray, time);
            }
            met = meet(&context.of_camera_ray(), ray, &self.stack, None);
            met.distance += before;
        }
        self.beta *= met.transmittance;
        self.stack = met.stack;
        if met.overflows {
            observer.cut(Truncation::Nested, self.beta);
        }
        let (hit, surface, boundary) = met.at?;
        Some(Place { hit, surface, distance: met.distance, boundary })
    }

    fn survives(&mut self, u: f32) -> bool {
        let (beta, survives) = roulette::<f32>(self.beta.into(), self.eta, u);
        self.beta = beta.into();
        survives
    }

    /// Continues along `next`, after a ray of length `distance`.
    fn advance(&mut self, job: &Job<'_>, vertex: &Vertex, next: &Scattered, time: f32, distance: f32) {
        self.beta *= next.sample.weight;
        self.eta *= next.sample.eta;
        if job.is_shadow_way(&next.sample) {
            self.arrival = self.arrival.through(distance, next.sample.eta != 1.0);
            return;
        }
        self.arrival = MisContext {
            p: vertex.surface.p,
            n: vertex.choice_normal(),
            pdf: next.sample.pdf,
            competing: if next.sample.lobe.is_delta() {
                CompetingStrategy::Nothing
            } else {
                CompetingStrategy::Choice
            },
            lights_are_points: job.lights_are_points(),
            time,
            is_seen: self.arrival.is_seen && next.sample.lobe.is_delta(),
            gone: 0.0,
            bent: false,
            view: 0.0,
        };
    }
}

/// Whether a path of throughput `beta` ends because nothing visible would remain of its light.
#[inline(always)]
pub(crate) fn is_faint<R: Real>(beta: Vec3x<R>) -> R::Mask {
    beta.max_element().lt(R::splat(FAINT))
}

/// Russian roulette by the numbers `u`: the throughput of the paths that survive, and whether they do.
#[inline(always)]
pub(crate) fn roulette<R: Real>(beta: Vec3x<R>, eta: R, u: R) -> (Vec3x<R>, R::Mask) {
    let q = (R::splat(ROULETTE_SCALE) * (beta * eta).max_element()).min(R::splat(1.0));
    (beta / q, !u.ge(q))
}
