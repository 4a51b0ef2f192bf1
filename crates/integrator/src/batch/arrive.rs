//! Second stage: rays meet surfaces, one by one. Emission is added, and the data of vertices are stored in columns.

use super::camera::Asked;
use super::rows::{Cuts, CutsOf, Paths, Result, Vertices};
use crate::job::Job;
use crate::observer::cut_short;
use crate::path::{End, PathState, Place, away};
use crate::sample::Sample;
use crate::trace_context::TraceContext;
use crate::vertex::{Vertex, oriented};
use crate::visibility::Solid;
use dapple_geometry::{Hit, Rays};
use dapple_math::Ray;
use dapple_sampling::Pattern;
use glam::Vec3;

/// No hit.
pub(super) const NOWHERE: Hit = Hit { t: f32::INFINITY, u: 0.0, v: 0.0, primitive: 0, object: u32::MAX };

/// What paths arrive with, and where results go.
pub(super) struct Arrival<'a> {
    pub job: &'a Job<'a>,
    pub depth: u32,
    /// Pattern and number of the points of samples.
    pub points: (Pattern, u32),
    pub asked: &'a Asked,
    pub paths: &'a Paths,
    pub next: &'a mut Paths,
    pub results: &'a mut [Result],
    pub cuts: &'a mut Cuts,
}

type Context<'a> = TraceContext<'a, Solid<true>>;

/// The ray of a path; camera rays have an end.
#[inline(always)]
fn ray(paths: &Paths, asked: &Asked, depth: u32, i: usize) -> Ray {
    let t_max = if depth == 0 { asked.t_max.get(i) } else { f32::INFINITY };
    Ray { o: paths.o.get(i), d: paths.d.get(i), t_max }
}

/// The time of a path, where anything moves.
#[inline(always)]
fn time(paths: &Paths, asked: &Asked, moves: bool, i: usize) -> f32 {
    if moves { asked.time.get(paths.place.get(i) as usize) } else { 0.0 }
}

impl Arrival<'_> {
    #[inline(always)]
    fn ray(&self, i: usize) -> Ray {
        ray(self.paths, self.asked, self.depth, i)
    }

    fn place(&self, i: usize) -> usize {
        self.paths.place.get(i) as usize
    }

    fn time(&self, i: usize) -> f32 {
        time(self.paths, self.asked, self.job.needs.time, i)
    }

    fn context(&self, i: usize) -> Context<'_> {
        // There are no alpha tests, whose key it would be.
        let (job, key) = (self.job, self.paths.key(i));
        TraceContext { job, scene: job.scene, visibility: Solid, time: self.time(i), key }
    }

    /// Finds the nearest hit of every ray.
    pub fn intersect(&mut self, hits: &mut [Hit]) {
        let results = &mut *self.results;
        let (paths, depth, asked, needs) = (self.paths, self.depth, self.asked, self.job.needs);
        let t_max = if depth == 0 { Some(asked.t_max.all()) } else { None };
        let rays = Rays::new(paths.len, paths.o.all(), paths.d.all(), t_max);
        let time = |i| time(paths, asked, needs.time, i);
        self.job.scene.accel.intersect_each(&rays, time, |i, hit| {
            hits[i] = hit.unwrap_or(NOWHERE);
            results[paths.place.get(i) as usize].rays += 1;
        });
    }

    /// Ends the paths that leave the scene, and stores the vertices of the others.
    pub fn vertices(&mut self, hits: &[Hit], vertices: &mut Vertices) {
        for (i, hit) in hits.iter().enumerate().take(self.paths.len) {
            let is_live = self.vertex(i, *hit, vertices);
            vertices.live.set(i, u32::from(is_live));
        }
    }

    /// Returns whether lanes have to scatter the path.
    #[inline(always)]
    fn vertex(&mut self, i: usize, hit: Hit, vertices: &mut Vertices) -> bool {
        let (ray, time, job) = (self.ray(i), self.time(i), self.job);
        let met = if hit.object == u32::MAX { None } else { self.met(i, &ray, hit) };
        let Some(at) = met else {
            self.escape(i, ray.d);
            return false;
        };
        let wo = away(ray.d);
        self.emission(i, &at, wo);
        let seen = (&at.hit, &at.surface);
        let shading = job.scene.shading(&at.hit, &at.surface, time);
        if shading.unlit || self.depth >= job.bounces {
            let frame = oriented(job, &shading, seen, wo, time);
            self.end(i, &Vertex::of(job, (&ray, wo), seen, shading, frame));
            return false;
        }
        let (frame, tilt) = oriented(job, &shading, seen, wo, time);
        let is_odd = tilt.is_some() || shading.material.is_mirror();
        if is_odd || !self.paths.beta.get(i).is_finite() {
            let vertex = Vertex::of(job, (&ray, wo), seen, shading, (frame, tilt));
            self.leave(i, &vertex, at.distance);
            return false;
        }
        let surface = &at.surface;
        vertices.p.set(i, surface.p);
        vertices.start.set(i, surface.start);
        vertices.p_error.set(i, surface.p_error);
        vertices.ng.set(i, surface.ng);
        vertices.frame[0].set(i, frame.x);
        vertices.frame[1].set(i, frame.y);
        vertices.frame[2].set(i, frame.z);
        vertices.materials.set(i, &shading.material);
        true
    }

    /// The place of a hit, behind everything that camera rays pass.
    #[inline(always)]
    fn met(&self, i: usize, ray: &Ray, hit: Hit) -> Option<Place> {
        let near = if self.depth == 0 { self.job.near_most } else { 0.0 };
        let surface = self.job.scene.accel.surface_inline(ray, self.time(i), &hit);
        PathState::place(&self.context(i), ray, (hit, surface), near, self.depth == 0)
    }

    /// Adds the emission of the surface.
    #[inline(always)]
    fn emission(&mut self, i: usize, at: &Place, wo: Vec3) {
        let (scene, beta) = (self.job.scene, self.paths.beta.get(i));
        let radiance = scene.emission(&at.hit, &at.surface, wo);
        if radiance == Vec3::ZERO && beta.is_finite() {
            return;
        }
        let arrival = self.paths.arrival(i, (self.time(i), self.depth));
        let le = at.emission(scene, wo, &arrival, self.job.settings.strategy);
        let place = self.place(i);
        self.results[place].radiance += beta * le;
    }

    /// Adds the environment.
    #[inline(always)]
    fn escape(&mut self, i: usize, d: Vec3) {
        if self.job.scene.environment.is_none() && self.paths.beta.get(i).is_finite() {
            return;
        }
        let mut state = self.state(i);
        let place = self.place(i);
        let mut cuts = CutsOf { cuts: self.cuts, place };
        state.escape(self.job, self.depth, d, &mut cuts);
        self.results[place].radiance = state.radiance;
    }

    #[inline(always)]
    fn state(&self, i: usize) -> PathState {
        let radiance = self.results[self.place(i)].radiance;
        self.paths.state(i, (self.time(i), self.depth), radiance)
    }

    /// Ends a path that is not scattered.
    #[inline(never)]
    fn end(&mut self, i: usize, vertex: &Vertex) {
        let mut cuts = CutsOf { place: self.place(i), cuts: self.cuts };
        cut_short(vertex, self.paths.beta.get(i), &mut cuts);
    }

    /// Scatters a path alone.
    #[inline(never)]
    fn leave(&mut self, i: usize, vertex: &Vertex, distance: f32) {
        let (place, time, mut state) = (self.place(i), self.time(i), self.state(i));
        let (pattern, n) = self.points;
        let sample = Sample { key: self.paths.key(i), s: self.paths.s.get(i), n, pattern, time };
        let (job, key) = (self.job, sample.key);
        let context = TraceContext { job, scene: job.scene, visibility: Solid::<true>, time, key };
        let mut cuts = CutsOf { cuts: self.cuts, place };
        let (end, mut rays) = (End { distance, boundary: None }, 0);
        let next = state.leave(&context, vertex, end, &sample, self.depth, &mut cuts, &mut rays);
        let result = &mut self.results[place];
        (result.radiance, result.rays) = (state.radiance, result.rays + rays as u32);
        if let Some(ray) = next {
            self.next.push(place, &sample, &state, &ray);
        }
    }
}
