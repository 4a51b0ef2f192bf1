//! A piecewise constant density on a grid over the unit square (marginal + conditional CDF, built in f64).
use glam::Vec2;
#[derive(Clone, Debug)]
pub struct Grid2d {}
/// A point of the unit square, the cell it lies in, and its density with respect to the unit square.
#[derive(Clone, Copy, Debug)]
pub struct GridSample {
    pub point: Vec2,
    pub cell: (u32, u32),
    pub pdf: f32,
}
impl Grid2d {
    /// `weights` row by row. None when the sum is zero or a weight is negative or not finite.
    pub fn new(_width: usize, _height: usize, _weights: &[f64]) -> Option<Self> {
        todo!()
    }
    pub fn sample(&self, _u: Vec2) -> GridSample {
        todo!()
    }
    pub fn pdf(&self, _point: Vec2) -> f32 {
        todo!()
    }
}
