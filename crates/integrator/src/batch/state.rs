//! What a batch keeps of its samples between the stages.

use super::camera::Asked;
use super::rows::{Cuts, Held, Paths, Result};
use crate::first_hit_sums::FirstHit;
use crate::job::Job;
use dapple_math::Ray;

/// The samples of a batch: paths by row, and results by place.
pub(super) struct State {
    pub asked: Asked,
    pub paths: Paths,
    pub next: Paths,
    pub results: Vec<Result>,
    pub cuts: Cuts,
    pub held: Vec<Held>,
    /// The first hits of all places, if they are asked for.
    pub firsts: Vec<FirstHit>,
}

impl State {
    /// The state of `rows` samples. `watched`: first hits are recorded.
    pub fn new(rows: usize, job: &Job<'_>, watched: bool) -> Self {
        Self {
            asked: Asked::new(),
            paths: Paths::new(),
            next: Paths::new(),
            results: vec![Result::default(); rows],
            cuts: Cuts::default(),
            held: vec![Held::NOTHING; rows],
            firsts: if watched { vec![FirstHit::of(job.settings); rows] } else { Vec::new() },
        }
    }

    /// Prepares a place for a new sample.
    pub fn clear(&mut self, place: usize, job: &Job<'_>) {
        self.results[place] = Result::default();
        if let Some(first) = self.firsts.get_mut(place) {
            *first = FirstHit::of(job.settings);
        }
    }

    /// Place of the sample of a row.
    #[inline(always)]
    pub fn place(&self, i: usize) -> usize {
        self.paths.place.get(i) as usize
    }

    /// The ray of a row and its time, which is 0 if nothing moves.
    #[inline(always)]
    pub fn ray(&self, i: usize, moves: bool) -> (Ray, f32) {
        (self.paths.ray(i), if moves { self.asked.time.get(self.place(i)) } else { 0.0 })
    }
}
