//! The s-th of n points, for a pattern and a key.
use crate::Key;
use glam::Vec2;
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pattern {
    Grid,
    Random,
    Stratified,
    #[default]
    Sobol,
}
/// s-th of n points in [0,1), strata in order.
pub fn point_1d(_pattern: Pattern, _s: u32, _n: u32, _key: Key) -> f32 {
    todo!()
}
/// s-th of n points in [0,1)², n split in the nearest-square a×b = n, strata in order.
pub fn point_2d(_pattern: Pattern, _s: u32, _n: u32, _key: Key) -> Vec2 {
    todo!()
}
/// As [`point_1d`], with the order of the cells permuted by the key, so that several dimensions can be padded.
pub fn padded_1d(_pattern: Pattern, _s: u32, _n: u32, _key: Key) -> f32 {
    todo!()
}
/// As [`point_2d`], with the order of the cells permuted by the key.
pub fn padded_2d(_pattern: Pattern, _s: u32, _n: u32, _key: Key) -> Vec2 {
    todo!()
}
