//! Choosing one of n things with given weights.
#[derive(Clone, Debug)]
pub struct Discrete {}
/// index, probability, and `u` stretched back to [0,1)
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    pub index: usize,
    pub pmf: f32,
    pub u: f32,
}
impl Discrete {
    /// None when no weight is positive or one is negative or not finite.
    pub fn new(_weights: &[f64]) -> Option<Self> {
        todo!()
    }
    pub fn sample(&self, _u: f32) -> Choice {
        todo!()
    }
    pub fn pmf(&self, _index: usize) -> f32 {
        todo!()
    }
    pub fn len(&self) -> usize {
        todo!()
    }
    pub fn is_empty(&self) -> bool {
        false
    }
}
