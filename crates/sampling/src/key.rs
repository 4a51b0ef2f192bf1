//! Randomness keyed by name: a pure function of (seed, pixel, branch, depth, dimension).
use crate::Dimension;
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(u64);
impl Key {
    /// The key of one pixel of one render.
    pub fn pixel(_seed: u64, _x: u32, _y: u32) -> Self {
        todo!()
    }
    /// The `n`-th child of a splitting (distribution tracer).
    pub fn branch(self, _n: u32) -> Self {
        todo!()
    }
    /// The key of one decision.
    pub fn at(self, _depth: u32, _dimension: Dimension) -> Self {
        todo!()
    }
    /// 64 well-mixed bits; stable over versions and machines.
    pub fn bits(self) -> u64 {
        todo!()
    }
}
