//! Means, variances and their errors, in f64.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    pub n: u64,
    pub mean: f64,
    m2: f64,
}
impl Moments {
    pub fn add(&mut self, _x: f64) {
        todo!()
    }
    pub fn merge(&mut self, _other: &Self) {
        todo!()
    }
    pub fn variance(&self) -> f64 {
        todo!()
    }
    pub fn standard_error(&self) -> f64 {
        todo!()
    }
}
