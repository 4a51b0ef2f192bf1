//! When the film is exposed.
/// Seconds, counted from `--at`; open ≤ close.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shutter {
    pub open: f32,
    pub close: f32,
}
impl Shutter {
    /// Time for u in [0,1): open + u·(close − open).
    pub fn time(&self, u: f32) -> f32 {
        self.open + u * (self.close - self.open)
    }
}
