//! Second stage: rays meet surfaces. The rows that lanes do not cover are computed one by one: their vertices, the
//! emission that they find, and for paths through bodies, panes and holes everything up to the next ray.

use super::rows::{Hits, Vertices, Watch};
use super::state::State;
use super::surfaces::Materials;
use crate::dimension::Dimension;
use crate::direct::Sides;
use crate::emission::escaped;
use crate::job::Job;
use crate::medium::MediumStack;
use crate::observer::cut_short;
use crate::path::{End, Known, PathState, Place, away, direct};
use crate::sample::Sample;
use crate::shadow::Passage;
use crate::trace_context::TraceContext;
use crate::vertex::{Vertex, oriented};
use crate::visibility::Visibility;
use dapple_geometry::{Hit, Rays};
use dapple_math::Ray;
use dapple_sampling::Pattern;
use glam::Vec3;

/// What paths arrive with, and where results go.
pub(super) struct Arrival<'a, V> {
    pub job: &'a Job<'a>,
    pub visibility: V,
    pub materials: &'a Materials,
    pub depth: u32,
    /// Pattern and number of the points of samples.
    pub points: (Pattern, u32),
    pub state: &'a mut State,
}

impl<V: Visibility> Arrival<'_, V> {
    #[inline(always)]
    fn time(&self, i: usize) -> f32 {
        self.state.ray(i, self.job.needs.time).1
    }

    fn sample(&self, i: usize) -> Sample {
        let (pattern, n) = self.points;
        let paths = &self.state.paths;
        Sample { key: paths.key(i), s: paths.s.get(i), n, pattern, time: self.time(i) }
    }

    /// The context of the ray of a path, or of its shadow ray.
    fn context(&self, sample: &Sample, alpha: Dimension) -> TraceContext<'_, V> {
        let (job, key) = (self.job, sample.alpha_key(self.depth, alpha));
        TraceContext { job, scene: job.scene, visibility: self.visibility, time: sample.time, key }
    }

    /// Finds the nearest hit of every ray, as if all surfaces were opaque.
    pub fn intersect(&mut self, hits: &mut Hits) {
        let (moves, mut results) = (self.job.needs.time, std::mem::take(&mut self.state.results));
        let state = &*self.state;
        let paths = &state.paths;
        let rays = Rays::new(paths.len, paths.o.all(), paths.d.all(), Some(paths.t_max.all()));
        let time = |i| if moves { state.asked.time.get(state.place(i)) } else { 0.0 };
        self.job.scene.accel.intersect_each(&rays, time, |i, hit| {
            hits.set(i, hit);
            results[state.place(i)].rays += 1;
        });
        self.state.results = results;
    }

    /// Computes the odd rows.
    pub fn vertices(&mut self, hits: &Hits, vertices: &mut Vertices) {
        for k in 0..vertices.odd.len {
            let i = vertices.odd.row.get(k) as usize;
            let is_live = self.vertex(i, hits.get(i), vertices);
            vertices.live.set(i, u32::from(is_live));
        }
    }

    /// Whether the row needs the state or the rules of paths that are not plain.
    #[inline(always)]
    fn is_special(&self, i: usize, hit: Option<Hit>) -> bool {
        let is_first = self.depth == 0 && self.materials.first_is_special;
        is_first || self.state.paths.holds(i) || hit.is_some_and(|hit| self.materials.is_special(hit.object))
    }

    /// Returns whether lanes have to scatter the path.
    #[inline(always)]
    fn vertex(&mut self, i: usize, hit: Option<Hit>, vertices: &mut Vertices) -> bool {
        if self.is_special(i, hit) {
            self.step(i, hit.map(|hit| (hit, vertices.surface(i))));
            return false;
        }
        let (ray, time, job) = (self.state.paths.ray(i), self.time(i), self.job);
        let Some(hit) = hit else {
            self.escape(i, ray.d);
            return false;
        };
        let known = vertices.surface(i);
        let surface = known.unwrap_or_else(|| job.scene.accel.surface_inline(&ray, time, &hit));
        if self.depth == 0 && job.passes(&ray, (&hit, &surface), job.near_most, time) {
            self.step(i, Some((hit, Some(surface))));
            return false;
        }
        let wo = away(ray.d);
        let at = Place { hit, surface, distance: hit.t * ray.d.length(), boundary: None };
        self.emission(i, &at, wo);
        let seen = (&at.hit, &at.surface);
        let shading = job.scene.shading(&at.hit, &at.surface, time);
        if shading.unlit || self.depth >= job.bounces {
            let frame = oriented(job, &shading, seen, wo, time);
            self.end(i, &Vertex::of(job, (&ray, wo), seen, shading, frame));
            return false;
        }
        let (frame, tilt) = oriented(job, &shading, seen, wo, time);
        if shading.material.is_mirror() || !self.state.paths.beta.get(i).is_finite() {
            let vertex = Vertex::of(job, (&ray, wo), seen, shading, (frame, tilt));
            self.leave(i, &vertex, at.distance);
            return false;
        }
        let surface = &at.surface;
        vertices.p.set(i, surface.p);
        vertices.start.set(i, surface.start);
        vertices.p_error.set(i, surface.p_error);
        vertices.ng.set(i, surface.ng);
        vertices.store_frame::<f32>(i, &frame.into());
        vertices.tilts.set(i, tilt.as_ref());
        vertices.materials.set(i, &shading.material);
        true
    }

    /// Adds the emission of the surface.
    #[inline(always)]
    fn emission(&mut self, i: usize, at: &Place, wo: Vec3) {
        let (scene, beta) = (self.job.scene, self.state.paths.beta.get(i));
        let radiance = scene.emission(&at.hit, &at.surface, wo);
        if radiance == Vec3::ZERO && beta.is_finite() {
            return;
        }
        let arrival = self.state.paths.arrival(i, (self.time(i), self.depth));
        let le = at.emission(scene, wo, &arrival, self.job.settings.strategy);
        let place = self.state.place(i);
        self.state.results[place].radiance += beta * le;
    }

    /// Adds the environment.
    #[inline(always)]
    fn escape(&mut self, i: usize, d: Vec3) {
        let (scene, beta) = (self.job.scene, self.state.paths.beta.get(i));
        if scene.environment.is_none() && beta.is_finite() {
            return;
        }
        let arrival = self.state.paths.arrival(i, (self.time(i), self.depth));
        let le = escaped(scene, d.normalize(), &arrival, self.job.settings.strategy);
        let place = self.state.place(i);
        self.state.results[place].radiance += beta * le;
    }

    #[inline(always)]
    fn path(&self, i: usize) -> PathState {
        let radiance = self.state.results[self.state.place(i)].radiance;
        self.state.paths.state(i, (self.time(i), self.depth), (radiance, &self.state.held))
    }

    fn watch(&mut self, place: usize) -> Watch<'_> {
        let State { cuts, firsts, .. } = &mut *self.state;
        Watch { cuts, place, first: firsts.get_mut(place) }
    }

    /// Ends a path that is not scattered.
    #[inline(never)]
    fn end(&mut self, i: usize, vertex: &Vertex) {
        let (place, beta) = (self.state.place(i), self.state.paths.beta.get(i));
        cut_short(vertex, beta, &mut self.watch(place));
    }

    /// Scatters a path alone.
    #[inline(never)]
    fn leave(&mut self, i: usize, vertex: &Vertex, distance: f32) {
        let (place, sample, mut state) = (self.state.place(i), self.sample(i), self.path(i));
        let (job, depth, visibility) = (self.job, self.depth, self.visibility);
        let key = sample.alpha_key(depth, Dimension::Alpha);
        let context = TraceContext { job, scene: job.scene, visibility, time: sample.time, key };
        let (end, mut rays) = (End { distance, boundary: None }, 0);
        let next = state.leave(&context, vertex, end, &sample, depth, &mut self.watch(place), &mut rays);
        self.go_on(place, &sample, (state, next), rays);
    }

    /// Scatters a path alone whose vertex is known, and whose emission is added.
    #[inline(never)]
    pub fn alone(&mut self, i: usize, hit: Option<Hit>) {
        let Some(hit) = hit else { return };
        let (ray, time, job) = (self.state.paths.ray(i), self.time(i), self.job);
        let surface = job.scene.accel.surface(&ray, time, &hit);
        let vertex = Vertex::new(job, (&ray, away(ray.d)), (&hit, &surface), (time, None));
        self.leave(i, &vertex, hit.t * ray.d.length());
    }

    /// Follows a path alone from its origin on.
    #[inline(never)]
    fn step(&mut self, i: usize, known: Option<Known>) {
        let (place, sample) = (self.state.place(i), self.sample(i));
        let (job, depth, visibility) = (self.job, self.depth, self.visibility);
        let key = sample.alpha_key(depth, Dimension::Alpha);
        let context = TraceContext { job, scene: job.scene, visibility, time: sample.time, key };
        // A camera ray may start elsewhere, and alpha tests may pass the hit.
        let (mut state, mut ray, near, known) = match depth {
            0 => {
                let (state, ray, near) = PathState::begin::<V>(job, self.state.paths.ray(i), sample.time);
                (state, ray, near, None)
            }
            _ => (self.path(i), self.state.paths.ray(i), 0.0, known.filter(|_| V::OPAQUE)),
        };
        let (way, mut rays) = ((&mut ray, near, known), 0);
        let next = state.step(&context, way, &sample, depth, &mut self.watch(place), &mut rays);
        self.go_on(place, &sample, (state, next), rays);
    }

    /// Keeps the result of a row, and its path if it goes on.
    fn go_on(&mut self, place: usize, sample: &Sample, (state, next): (PathState, Option<Ray>), rays: u64) {
        let State { next: paths, results, held, .. } = &mut *self.state;
        let result = &mut results[place];
        (result.radiance, result.rays) = (state.radiance, result.rays + rays as u32);
        if let Some(ray) = next {
            paths.push(place, sample, (&state, &ray), held);
        }
    }

    /// Adds the light of row `i` whose shadow ray hits a surface that may not stop it. `light`: without this surface.
    #[inline(never)]
    pub fn light_through(&mut self, i: usize, hit: Option<Hit>, (ray, light): (Ray, Vec3)) {
        let (place, sample) = (self.state.place(i), self.sample(i));
        let outside = MediumStack::EMPTY;
        let passage = self.context(&sample, Dimension::ShadowAlpha).passage(&ray, &outside, f32::INFINITY);
        let is_open = match passage {
            Passage::Blocked => return,
            Passage::Open(way) => way.passed == 0,
            Passage::Lost => false,
        };
        if is_open {
            self.state.results[place].radiance += light;
            return;
        }
        // The weight of the light depends on what is passed.
        let Some(hit) = hit else { return };
        let (job, ray, time) = (self.job, self.state.paths.ray(i), sample.time);
        let surface = job.scene.accel.surface(&ray, time, &hit);
        let vertex = Vertex::new(job, (&ray, away(ray.d)), (&hit, &surface), (time, None));
        let (beta, media) = (self.state.paths.beta.get(i), Sides { near: &outside, far: &outside });
        let (depth, visibility) = (self.depth, self.visibility);
        let lit = (beta, &mut self.watch(place));
        let direct = direct(job, visibility, &vertex, &sample, depth, media, lit, &mut 0);
        self.state.results[place].radiance += beta * direct;
    }
}
