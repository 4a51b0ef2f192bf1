//! Traces a batch: its stages in turn, until all of its paths have ended.

use super::arrive::{Arrival, NOWHERE};
use super::camera::{self, Asked, CameraRays};
use super::lights::Lights;
use super::points::PointSet;
use super::rows::{Cuts, Paths, Result, Shadows, Vertices};
use super::shade::Shading;
use crate::bias_report::BiasReport;
use crate::dimension::Dimension;
use crate::job::Job;
use crate::sample::Sample;
use dapple_geometry::{Hit, Rays};
use dapple_math::lanes::{Isa, dispatch};
use glam::Vec3;

/// Samples that are traced together. Everything is kept in columns of the same length, which are used again.
pub(crate) struct Batch {
    rows: usize,
    /// Number of samples.
    len: usize,
    /// The points of the samples, and their number.
    set: Option<(PointSet, u32)>,
    asked: Asked,
    paths: Paths,
    next: Paths,
    hits: Vec<Hit>,
    vertices: Vertices,
    shadows: Shadows,
    results: Vec<Result>,
    cuts: Cuts,
}

/// A finished sample.
pub(crate) struct Done {
    pub pixel: (u32, u32),
    pub index: u32,
    pub value: Vec3,
    pub weight: f32,
    pub bias: BiasReport,
    pub rays: u64,
}

impl Batch {
    pub fn new(rows: usize) -> Self {
        Self {
            rows,
            len: 0,
            set: None,
            asked: Asked::new(),
            paths: Paths::new(),
            next: Paths::new(),
            hits: vec![NOWHERE; rows],
            vertices: Vertices::new(),
            shadows: Shadows::new(),
            results: vec![Result::default(); rows],
            cuts: Cuts::default(),
        }
    }

    /// Number of samples in the batch.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        (self.len, self.set, self.paths.len) = (0, None, 0);
        self.cuts.clear();
    }

    /// Adds a sample; returns false if it has to be in another batch.
    pub fn add(&mut self, job: &Job<'_>, pixel: (u32, u32), index: u32) -> bool {
        let sample = Sample::new(job.settings, pixel, index);
        let set = PointSet::new(sample.pattern, sample.n);
        if self.len == self.rows || self.set.is_some_and(|(other, _)| other != set) {
            return false;
        }
        let place = self.len;
        self.set = Some((set, sample.n));
        self.len += 1;
        self.asked.x.set(place, pixel.0);
        self.asked.y.set(place, pixel.1);
        self.asked.index.set(place, index);
        let time = if job.needs.time { job.time(sample.point_1d(0, Dimension::Time)) } else { 0.0 };
        self.asked.time.set(place, time);
        self.paths.start(place, &sample);
        self.results[place] = Result::default();
        true
    }

    /// Traces all samples; returns false if the job was stopped before that.
    pub(super) fn trace(&mut self, job: &Job<'_>, lights: &Lights, isa: Isa) -> bool {
        let Some((set, n)) = self.set else { return true };
        let pattern = job.settings.pattern;
        self.paths.len = self.len;
        if job.camera.motion.is_some() {
            camera::moving(job, (pattern, n), &mut self.asked, &mut self.paths);
        } else {
            let warp = job.settings.filter.warp();
            dispatch(isa, CameraRays { job, set, warp, asked: &mut self.asked, paths: &mut self.paths });
        }
        for depth in 0.. {
            if self.paths.len == 0 {
                break;
            }
            if job.is_stopped() {
                return false;
            }
            self.arrive(job, depth, n);
            self.shade(job, lights, isa, set, depth);
            self.occlude(job);
            std::mem::swap(&mut self.paths, &mut self.next);
        }
        self.cuts.sort();
        true
    }

    fn arrive(&mut self, job: &Job<'_>, depth: u32, n: u32) {
        self.next.len = 0;
        let mut arrival = Arrival {
            job,
            depth,
            points: (job.settings.pattern, n),
            asked: &self.asked,
            paths: &self.paths,
            next: &mut self.next,
            results: &mut self.results,
            cuts: &mut self.cuts,
        };
        arrival.intersect(&mut self.hits);
        arrival.vertices(&self.hits, &mut self.vertices);
    }

    fn shade(&mut self, job: &Job<'_>, lights: &Lights, isa: Isa, set: PointSet, depth: u32) {
        self.shadows.len = 0;
        let shading = Shading {
            job,
            lights,
            depth,
            set,
            asked: &self.asked,
            paths: &self.paths,
            vertices: &self.vertices,
            next: &mut self.next,
            shadows: &mut self.shadows,
            cuts: &mut self.cuts,
        };
        dispatch(isa, shading);
    }

    /// Adds the light of the shadow rays that nothing occludes.
    fn occlude(&mut self, job: &Job<'_>) {
        let accel = &job.scene.accel;
        let (shadows, asked, results) = (&self.shadows, &self.asked, &mut self.results);
        let place = |i: usize| shadows.place.get(i) as usize;
        let time = |i: usize| if job.needs.time { asked.time.get(place(i)) } else { 0.0 };
        // No ray with an end below 0 hits anything.
        let rays = Rays::new(shadows.len, shadows.o.all(), shadows.d.all(), Some(shadows.t_max.all()));
        accel.occluded_each(&rays, time, |i, is_occluded| {
            let result = &mut results[place(i)];
            result.rays += u32::from(shadows.t_max.get(i) >= 0.0);
            if !is_occluded {
                result.radiance += shadows.light.get(i);
            }
        });
    }

    /// The samples, in the order in which they were added.
    pub fn done(&self) -> impl Iterator<Item = Done> + '_ {
        let mut from = 0;
        (0..self.len).map(move |place| {
            let (asked, result) = (&self.asked, &self.results[place]);
            Done {
                pixel: (asked.x.get(place), asked.y.get(place)),
                index: asked.index.get(place),
                value: result.radiance,
                weight: asked.weight.get(place),
                bias: self.cuts.report(place, &mut from),
                rays: result.rays.into(),
            }
        })
    }
}
