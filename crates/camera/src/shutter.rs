//! When the film is exposed: one more integral, over time.
/// Seconds, counted from `--at`; open ≤ close. Equal ends are an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shutter {
    /// When the shutter opens, s.
    pub open: f32,
    /// When the shutter closes, s.
    pub close: f32,
}
impl Shutter {
    /// Time in seconds for u in \[0,1), uniform over the exposure: open·(1 − u) + close·u, which hits both ends exactly
    /// and stays between them.
    #[inline]
    pub fn time(&self, u: f32) -> f32 {
        (self.open * (1.0 - u) + self.close * u).clamp(self.open, self.close.max(self.open))
    }
    /// Whether nothing can move while the shutter is open.
    pub fn is_instant(&self) -> bool {
        self.close <= self.open
    }
}
