//! Sample points over lanes.

use crate::Dimension;
use dapple_math::lanes::{Real, Vec2x, Word};
use dapple_sampling::lanes::Keyx;
use dapple_sampling::lanes::pattern::{Index, padded_1d, padded_2d};
use dapple_sampling::pattern::{Pattern, cells};

/// The set of points that all samples of a batch belong to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct PointSet {
    pattern: Pattern,
    n: u32,
    cells: [u32; 2],
}

impl PointSet {
    /// The set of `n` points. Sobol points depend on `n` below 16 only, and random ones not at all, so that samples of
    /// longer renders share a set.
    pub fn new(pattern: Pattern, n: u32) -> Self {
        let n = match pattern {
            Pattern::Sobol => n.min(16),
            Pattern::Random => 1,
            Pattern::Grid | Pattern::Stratified => n,
        };
        Self { pattern, n, cells: cells(pattern, n) }
    }
}

/// Samples, one per lane: see [`Sample`](crate::sample::Sample).
#[derive(Clone, Copy)]
pub(super) struct Samples<R: Real> {
    pub set: PointSet,
    pub key: Keyx<R::Word>,
    pub s: Index<R::Word>,
}

impl<R: Real> Samples<R> {
    #[inline(always)]
    pub fn point_1d(&self, depth: u32, dimension: Dimension) -> R {
        padded_1d(self.set.pattern, self.s, self.set.n, self.at(depth, dimension))
    }

    #[inline(always)]
    pub fn point_2d(&self, depth: u32, dimension: Dimension) -> Vec2x<R> {
        padded_2d(self.set.pattern, self.s, self.set.cells, self.at(depth, dimension))
    }

    #[inline(always)]
    fn at(&self, depth: u32, dimension: Dimension) -> Keyx<R::Word> {
        self.key.at(R::Word::splat(depth), dimension)
    }
}
