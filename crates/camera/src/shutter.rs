//! When the film is exposed: one more integral, over time.
/// Seconds, counted from `--at`; open ≤ close. Equal ends are an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shutter {
    /// When the shutter opens, s.
    pub open: f64,
    /// When the shutter closes, s.
    pub close: f64,
}
impl Shutter {
    /// How long it is open, s; 0 for an instant.
    pub fn seconds(&self) -> f32 {
        (self.close - self.open).max(0.0) as f32
    }
    /// Seconds since it opened, for u in \[0,1), uniform over the exposure. Counted from the opening, so that a short
    /// exposure late in an animation keeps all digits of u.
    #[inline]
    pub fn time(&self, u: f32) -> f32 {
        self.seconds() * u
    }
    /// Whether nothing can move while the shutter is open.
    pub fn is_instant(&self) -> bool {
        self.seconds() <= 0.0
    }
}
