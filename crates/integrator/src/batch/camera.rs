//! First stage: camera rays.

use super::columns::{Numbers, Words};
use super::points::{PointSet, Samples};
use super::rows::{IS_SEEN, Paths};
use crate::Dimension;
use crate::emission::MisContext;
use crate::job::Job;
use crate::path::PathState;
use crate::sample::Sample;
use dapple_camera::lanes::FilterWarp;
use dapple_math::lanes::{Kernel, Real, Vec2x, Vec3x, Word};
use dapple_sampling::Pattern;
use dapple_sampling::lanes::Keyx;
use dapple_sampling::lanes::pattern::Index;
use glam::Vec3;

/// Samples by place, as they are asked for.
pub(super) struct Asked {
    pub x: Words,
    pub y: Words,
    pub index: Words,
    /// Seconds since the shutter opened.
    pub time: Numbers,
    /// Filter weight.
    pub weight: Numbers,
}

impl Asked {
    pub fn new() -> Self {
        let (words, numbers) = (Words::new, Numbers::new);
        Self { x: words(), y: words(), index: words(), time: numbers(), weight: numbers() }
    }
}

/// Computes the camera rays of the samples, whose keys and indices `paths` holds.
pub(super) struct CameraRays<'a> {
    pub job: &'a Job<'a>,
    pub set: PointSet,
    pub warp: FilterWarp,
    pub asked: &'a mut Asked,
    pub paths: &'a mut Paths,
}

impl Kernel for CameraRays<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(mut self) {
        for i in (0..self.paths.len).step_by(R::LANES) {
            self.rays::<R>(i);
        }
    }
}

impl CameraRays<'_> {
    #[inline(always)]
    fn rays<R: Real>(&mut self, i: usize) {
        let (job, paths) = (self.job, &mut *self.paths);
        let key = Keyx::from_words([paths.key[0].load(i), paths.key[1].load(i)]);
        let samples = Samples::<R> { set: self.set, key, s: Index::new(paths.s.load(i)) };
        let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
        let (offset, weight) = match job.needs.pixel {
            true => self.warp.sample(samples.point_2d(0, Dimension::Pixel)),
            false => (Vec2x::new(zero, zero), one),
        };
        let lens = match cfg!(not(without = "lens")) && job.needs.lens {
            true => samples.point_2d(0, Dimension::Lens),
            false => Vec2x::new(half, half),
        };
        let pixel = [self.asked.x.load(i), self.asked.y.load(i)];
        let fraction = offset + Vec2x::new(half, half);
        let ray = job.camera.rays::<R>(pixel, fraction, job.settings.size, lens);
        self.asked.weight.store(i, weight);
        paths.t_max.store(i, ray.t_max);
        paths.o.store(i, ray.o);
        paths.d.store(i, ray.d);
        paths.beta.store(i, Vec3x::<R>::splat(Vec3::ONE));
        paths.eta.store(i, one);
        paths.p.store(i, Vec3x::<R>::splat(MisContext::CAMERA.p));
        paths.n.store(i, Vec3x::<R>::splat(MisContext::CAMERA.n));
        paths.pdf.store(i, R::splat(MisContext::CAMERA.pdf));
        paths.flags.store(i, R::Word::splat(IS_SEEN));
    }
}

/// The camera rays of a moving camera, one by one.
pub(super) fn moving(job: &Job<'_>, (pattern, n): (Pattern, u32), asked: &mut Asked, paths: &mut Paths) {
    let rows = std::mem::take(&mut paths.len);
    for i in 0..rows {
        let (key, s, time) = (paths.key(i), paths.s.get(i), asked.time.get(i));
        let sample = Sample { key, s, n, pattern, time };
        let (ray, weight) = sample.camera_ray(job, (asked.x.get(i), asked.y.get(i)));
        asked.weight.set(i, weight);
        paths.push(i, &sample, (&PathState::default(), &ray), &mut []);
    }
}
