//! Sums of samples in f64: mean and variance per pixel.
use dapple_imaging::Picture;
use glam::Vec3;
/// x0 ≤ x < x1, y0 ≤ y < y1, top-left origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    pub x0: u32,
    pub y0: u32,
    pub x1: u32,
    pub y1: u32,
}
#[derive(Clone, Debug)]
pub struct Film {}
impl Film {
    pub fn new(_rect: PixelRect) -> Self {
        todo!()
    }
    /// Adds one sample; a non-finite one adds zero, still counts, and returns false.
    pub fn add(&mut self, _x: u32, _y: u32, _value: Vec3, _weight: f32) -> bool {
        todo!()
    }
    /// Copies the pixels of a disjoint tile in.
    pub fn put(&mut self, _tile: &Film) {
        todo!()
    }
    pub fn mean(&self) -> Picture {
        todo!()
    }
    /// Variance of the mean, per channel.
    pub fn variance(&self) -> Picture {
        todo!()
    }
    pub fn count(&self, _x: u32, _y: u32) -> u64 {
        todo!()
    }
}
