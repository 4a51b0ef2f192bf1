//! Traces a batch: its stages in turn, until all of its paths have ended.

use super::arrive::Arrival;
use super::camera::{self, CameraRays};
use super::escapes::Escapes;
use super::lights::Lights;
use super::points::PointSet;
use super::rows::{Hits, Shadows, Vertices};
use super::shade::Shading;
use super::state::State;
use super::surfaces::{Materials, Surfaces};
use crate::bias_report::BiasReport;
use crate::dimension::Dimension;
use crate::first_hit_sums::FirstHit;
use crate::job::Job;
use crate::kernel::{Sight, cutout};
use crate::sample::Sample;
use crate::visibility::{Solid, Visibility};
use dapple_geometry::Rays;
use dapple_math::lanes::{Isa, dispatch};
use dapple_sampling::Pattern;
use glam::Vec3;

/// Samples that are traced together. Everything is kept in columns of the same length, which are used again.
pub(crate) struct Batch {
    rows: usize,
    /// Number of samples.
    len: usize,
    /// The points of the samples, and their number.
    set: Option<(PointSet, u32)>,
    hits: Hits,
    vertices: Vertices,
    shadows: Shadows,
    /// Shadow rays that are tested once more.
    again: Vec<u32>,
    /// Rows whose rays pass over facets.
    over: Vec<u32>,
    state: State,
}

/// What the batches of a render share.
pub(super) struct Shared {
    pub lights: Lights,
    pub materials: Materials,
    pub isa: Isa,
    pub sight: Sight,
    /// First hits are recorded.
    pub watched: bool,
}

/// A finished sample.
pub(crate) struct Done<'a> {
    pub pixel: (u32, u32),
    pub index: u32,
    pub value: Vec3,
    pub weight: f32,
    pub bias: BiasReport,
    /// Its first hit, if that is asked for.
    pub first: Option<&'a FirstHit>,
    pub rays: u64,
}

impl Batch {
    pub(super) fn new(rows: usize, job: &Job<'_>, shared: &Shared) -> Self {
        Self {
            rows,
            len: 0,
            set: None,
            hits: Hits::new(),
            vertices: Vertices::new(),
            shadows: Shadows::new(),
            again: Vec::new(),
            over: Vec::new(),
            state: State::new(rows, job, shared.watched),
        }
    }

    /// Number of samples in the batch.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        (self.len, self.set, self.state.paths.len) = (0, None, 0);
        self.state.cuts.clear();
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
        let (asked, paths) = (&mut self.state.asked, &mut self.state.paths);
        asked.x.set(place, pixel.0);
        asked.y.set(place, pixel.1);
        asked.index.set(place, index);
        let time = if job.needs.time { job.time(sample.point_1d(0, Dimension::Time)) } else { 0.0 };
        asked.time.set(place, time);
        paths.start(place, &sample);
        self.state.clear(place, job);
        true
    }

    /// Traces all samples; returns false if the job was stopped before that.
    pub(super) fn trace(&mut self, job: &Job<'_>, shared: &Shared) -> bool {
        match shared.sight {
            Sight::Plain => self.trace_in((job, Solid::<true>), shared),
            Sight::Solid => self.trace_in((job, Solid::<false>), shared),
            Sight::Cutout => self.trace_in((job, cutout::<false>(job)), shared),
        }
    }

    fn trace_in<V: Visibility>(&mut self, at: (&Job<'_>, V), shared: &Shared) -> bool {
        let job = at.0;
        let Some((set, n)) = self.set else { return true };
        let points = (job.settings.pattern, n);
        let State { asked, paths, .. } = &mut self.state;
        paths.len = self.len;
        if job.camera.motion.is_some() {
            camera::moving(job, points, asked, paths);
        } else {
            let warp = job.settings.filter.warp();
            dispatch(shared.isa, CameraRays { job, set, warp, asked, paths });
        }
        for depth in 0.. {
            if self.state.paths.len == 0 {
                break;
            }
            if job.is_stopped() {
                return false;
            }
            self.arrive(at, shared, (depth, points));
            self.shade(at, shared, set, (depth, points));
            self.occlude(at, shared, (depth, points));
            let State { paths, next, .. } = &mut self.state;
            std::mem::swap(paths, next);
        }
        self.state.cuts.sort();
        true
    }

    fn arrive<V: Visibility>(
        &mut self,
        (job, visibility): (&Job<'_>, V),
        shared: &Shared,
        (depth, points): (u32, (Pattern, u32)),
    ) {
        self.state.next.len = 0;
        self.vertices.tilts.any = false;
        let (materials, state) = (&shared.materials, &mut self.state);
        let mut arrival = Arrival { job, visibility, materials, depth, points, state };
        arrival.intersect(&mut self.hits);
        let (asked, paths) = (&arrival.state.asked, &arrival.state.paths);
        let (hits, vertices) = (&self.hits, &mut self.vertices);
        let is_special = depth == 0 && materials.first_is_special;
        if is_special {
            vertices.all_odd(paths.len);
        } else {
            let facets = job.scene.accel.facets();
            dispatch(shared.isa, Surfaces { job, facets, materials, depth, asked, paths, hits, vertices });
        }
        arrival.vertices(&self.hits, &mut self.vertices);
        let State { paths, results, .. } = &mut self.state;
        if self.vertices.escaped.len > 0 {
            dispatch(shared.isa, Escapes { job, rows: &self.vertices.escaped, paths, results });
        }
    }

    fn shade<V: Visibility>(
        &mut self,
        (job, visibility): (&Job<'_>, V),
        shared: &Shared,
        set: PointSet,
        (depth, points): (u32, (Pattern, u32)),
    ) {
        self.shadows.len = 0;
        self.over.clear();
        let State { asked, paths, next, cuts, .. } = &mut self.state;
        let shading = Shading {
            job,
            lights: &shared.lights,
            depth,
            set,
            asked,
            paths,
            vertices: &self.vertices,
            next,
            shadows: &mut self.shadows,
            cuts,
            over: &mut self.over,
        };
        dispatch(shared.isa, shading);
        let (materials, state) = (&shared.materials, &mut self.state);
        let mut arrival = Arrival { job, visibility, materials, depth, points, state };
        for row in self.over.iter().map(|row| *row as usize) {
            arrival.alone(row, self.hits.get(row));
        }
    }

    /// Adds the light of the shadow rays that nothing occludes, or whose occluders let it pass.
    fn occlude<V: Visibility>(
        &mut self,
        (job, visibility): (&Job<'_>, V),
        shared: &Shared,
        (depth, points): (u32, (Pattern, u32)),
    ) {
        let asks_again = !V::OPAQUE || (!V::PLAIN && job.clear_ways);
        let State { asked, results, .. } = &mut self.state;
        let (shadows, again) = (&self.shadows, &mut self.again);
        again.clear();
        let place = |i: usize| shadows.place.get(i) as usize;
        let time = |i: usize| if job.needs.time { asked.time.get(place(i)) } else { 0.0 };
        // No ray with an end below 0 hits anything.
        let rays = Rays::new(shadows.len, shadows.o.all(), shadows.d.all(), Some(shadows.t_max.all()));
        job.scene.accel.occluded_each(&rays, time, |i, is_occluded| {
            let result = &mut results[place(i)];
            result.rays += u32::from(shadows.t_max.get(i) >= 0.0);
            if !is_occluded {
                result.radiance += shadows.light.get(i);
            } else if asks_again {
                again.push(i as u32);
            }
        });
        let (materials, state) = (&shared.materials, &mut self.state);
        let mut arrival = Arrival { job, visibility, materials, depth, points, state };
        for i in again.iter().map(|i| *i as usize) {
            let row = shadows.row.get(i) as usize;
            arrival.light_through(row, self.hits.get(row), (rays.ray(i), shadows.light.get(i)));
        }
    }

    /// The samples, in the order in which they were added.
    pub fn done(&self) -> impl Iterator<Item = Done<'_>> {
        let mut from = 0;
        (0..self.len).map(move |place| {
            let State { asked, results, cuts, firsts, .. } = &self.state;
            let result = &results[place];
            Done {
                pixel: (asked.x.get(place), asked.y.get(place)),
                index: asked.index.get(place),
                value: result.radiance,
                weight: asked.weight.get(place),
                bias: cuts.report(place, &mut from),
                first: firsts.get(place),
                rays: result.rays.into(),
            }
        })
    }
}
