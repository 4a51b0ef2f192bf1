//! Pixel filters, sampled by warping the pixel point.
use glam::Vec2;
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    Box { radius: f32 },
    Tent,
    Gaussian,
    Mitchell,
    BlackmanHarris,
}
impl Default for Filter {
    fn default() -> Self {
        Self::Box { radius: 0.5 }
    }
}
impl Filter {
    /// Offset from the pixel's centre in pixels, and the weight the sample carries (1 unless the filter has negative lobes).
    pub fn sample(&self, _u: Vec2) -> (Vec2, f32) {
        todo!()
    }
}
// plus FromStr (`box[:r]`, tent, gaussian, mitchell, blackman-harris), Display
