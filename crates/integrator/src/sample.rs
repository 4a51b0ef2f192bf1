//! One sample of one pixel: its random numbers, keyed by decision, and its camera ray.

use crate::Dimension;
use crate::effects::Effect;
use crate::job::Job;
use crate::places::moves;
use crate::settings::Settings;
use dapple_math::Ray;
use dapple_sampling::{Key, Pattern, padded_1d, padded_2d};
use glam::Vec2;

/// The s-th of n samples of a pixel. Every number it uses is a pure function of (key, s, n, depth, dimension).
#[derive(Clone, Copy)]
pub(crate) struct Sample {
    pub key: Key,
    pub s: u32,
    pub n: u32,
    pub pattern: Pattern,
    /// Seconds since the shutter opened.
    pub time: f32,
}

impl Sample {
    /// Sample `index` of pixel (x, y). With a sample count, the n points form one set; without one (with a time limit)
    /// they form blocks, each a set of its own, so that the samples finished so far are an unbiased estimate.
    pub fn new(settings: &Settings, (x, y): (u32, u32), index: u32) -> Self {
        let key = Key::pixel(settings.seed, x, y);
        let n = settings.block();
        match settings.pattern {
            Pattern::Sobol | Pattern::Random => {
                Self { key, s: index, n: n.max(index + 1), pattern: settings.pattern, time: 0.0 }
            }
            pattern => Self {
                key: if index < n { key } else { key.branch(index / n) },
                s: index % n,
                n,
                pattern,
                time: 0.0,
            },
        }
    }

    /// The sample with its time in the shutter interval: all rays of its path see the scene at this time. No number is
    /// drawn if nothing moves.
    pub fn timed(self, job: &Job<'_>) -> Self {
        if cfg!(without = "time") || !job.needs.time {
            return self;
        }
        Self { time: job.time(self.point_1d(0, Dimension::Time)), ..self }
    }

    /// Key of the alpha tests of a ray.
    #[inline(always)]
    pub fn alpha_key(&self, depth: u32, dimension: Dimension) -> Key {
        self.key.at(depth, dimension).branch(self.s)
    }

    pub fn point_1d(&self, depth: u32, dimension: Dimension) -> f32 {
        #[cfg(test)]
        drawn::note(depth, dimension);
        padded_1d(self.pattern, self.s, self.n, self.key.at(depth, dimension))
    }

    pub fn point_2d(&self, depth: u32, dimension: Dimension) -> Vec2 {
        #[cfg(test)]
        drawn::note(depth, dimension);
        padded_2d(self.pattern, self.s, self.n, self.key.at(depth, dimension))
    }

    /// As [`point_1d`](Self::point_1d), for a decision outside the table.
    pub fn named_1d(&self, depth: u32, decision: u32) -> f32 {
        padded_1d(self.pattern, self.s, self.n, self.key.at(depth, decision))
    }

    /// As [`point_2d`](Self::point_2d), for a decision outside the table.
    pub fn named_2d(&self, depth: u32, decision: u32) -> Vec2 {
        padded_2d(self.pattern, self.s, self.n, self.key.at(depth, decision))
    }

    /// The camera ray through a pixel, and its pixel filter weight.
    pub fn camera_ray(&self, job: &Job<'_>, pixel: (u32, u32)) -> (Ray, f32) {
        let (offset, weight) = match job.needs.pixel {
            true => job.settings.filter.sample(self.point_2d(0, Dimension::Pixel)),
            false => (Vec2::ZERO, 1.0),
        };
        let lens = if cfg!(not(without = "lens")) && job.needs.lens {
            self.point_2d(0, Dimension::Lens)
        } else {
            Vec2::splat(0.5)
        };
        (job.camera_ray(pixel, offset, lens, self.time), weight)
    }
}

impl Job<'_> {
    /// The camera ray through a pixel, `offset` from the pixel centre, at a time.
    pub fn camera_ray(&self, pixel: (u32, u32), offset: Vec2, lens: Vec2, time: f32) -> Ray {
        let fraction = offset + Vec2::splat(0.5);
        match self.camera.motion.as_ref().filter(|_| cfg!(not(without = "time"))) {
            None => self.camera.ray(pixel, fraction, self.settings.size, lens),
            Some(_) => self.camera.at(time).ray(pixel, fraction, self.settings.size, lens),
        }
    }

    /// The time at `u` of the shutter interval, in seconds since the shutter opened.
    pub fn time(&self, u: f32) -> f32 {
        if self.is_blurred_by_motion() { self.scene.shutter.time(u) } else { 0.0 }
    }

    /// Whether something moves, and the time integral is not off.
    fn is_blurred_by_motion(&self) -> bool {
        moves(self.scene) && !self.settings.plans.is_off(Effect::Time)
    }
}

#[cfg(test)]
pub(crate) mod drawn {
    //! Record of the drawn numbers, for tests.
    use crate::Dimension;
    use std::cell::RefCell;

    thread_local! {
        pub static DRAWN: RefCell<Vec<(u32, Dimension)>> = const { RefCell::new(Vec::new()) };
    }

    pub fn note(depth: u32, dimension: Dimension) {
        DRAWN.with_borrow_mut(|all| all.push((depth, dimension)));
    }

    /// All numbers drawn since the last call.
    pub fn take() -> Vec<(u32, Dimension)> {
        DRAWN.take()
    }
}
