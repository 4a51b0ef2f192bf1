//! The shutter: the time interval over which a sample's time is drawn.
/// The exposure interval in seconds relative to `--at`, with open ≤ close. Equal times are an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shutter {
    /// Time when the shutter opens, in seconds.
    pub open: f64,
    /// Time when the shutter closes, in seconds.
    pub close: f64,
}
impl Shutter {
    /// Returns the duration of the exposure in seconds, which is 0 for an instant.
    pub fn seconds(&self) -> f32 {
        (self.close - self.open).max(0.0) as f32
    }
    /// Samples the time uniformly over the exposure by u in \[0,1), in seconds after the shutter opens. It is relative
    /// to the opening so that a short exposure late in an animation keeps the full precision of u.
    #[inline]
    pub fn time(&self, u: f32) -> f32 {
        self.seconds() * u
    }
    /// Returns whether the exposure is an instant, so that nothing moves.
    pub fn is_instant(&self) -> bool {
        self.seconds() <= 0.0
    }
}
