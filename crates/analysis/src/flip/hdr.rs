//! The exposures and the tone curve of HDR-ꟻLIP.

use dapple_imaging::{Image, color};
use glam::Vec3;

/// A series of evenly spaced exposures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposures {
    /// The darkest exposure in stops, which maps the brightest pixel of the reference just below white.
    pub start: f32,
    /// The brightest exposure in stops, which does the same for the median pixel.
    pub stop: f32,
    /// Number of exposures.
    pub count: usize,
}

impl Exposures {
    /// The exposures in stops.
    pub fn stops(self) -> impl Iterator<Item = f32> {
        let step = (self.stop - self.start) / (self.count.max(2) - 1) as f32;
        (0..self.count).map(move |i| self.start + i as f32 * step)
    }
}

/// The ACES curve (a x² + b x + c)/(d x² + e x + f), its input scaled by 0.6 [Andersson et al. 2021].
const ACES: [f32; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];
/// Output of the tone curve for the brightest pixel at the first exposure.
const WHITE: f32 = 0.85;

/// The exposures from that of the brightest to that of the median pixel of `reference`, at most one stop apart
/// [Andersson et al. 2021, §3]. The luminance of the brightest pixel and that of the median are clamped to at least
/// 2⁻²³, for references that are black or mostly black.
pub fn exposures(reference: &Image) -> Exposures {
    let finite = reference.pixels.iter().filter(|p| p.is_finite());
    let mut luminance: Vec<f32> = finite.map(|p| color::luminance(p.max(Vec3::ZERO))).collect();
    luminance.sort_by(f32::total_cmp);
    let brightest = luminance.last().copied().unwrap_or(0.0).max(f32::EPSILON);
    let median = median(&luminance).max(f32::EPSILON);
    let full = brightest_input();
    let (start, stop) = (libm::log2f(full / brightest), libm::log2f(full / median));
    Exposures { start, stop, count: ((stop - start).ceil() as usize).max(2) }
}

fn median(sorted: &[f32]) -> f32 {
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

/// The input that the curve maps to [`WHITE`]: the larger root of a quadratic.
fn brightest_input() -> f32 {
    let [a, b, c, d, e, f] = ACES;
    let (a, b, c) = (a - WHITE * d, b - WHITE * e, c - WHITE * f);
    let half = -0.5 * b / a;
    half + libm::sqrtf(half * half - c / a)
}

/// A linear colour at the given exposure, tone-mapped and clipped to 0…1.
pub(super) fn shown(linear: Vec3, stops: f32) -> Vec3 {
    let [a, b, c, d, e, f] = ACES;
    // Above 1e15 the curve is saturated, and the squares would overflow.
    let x = (linear * libm::exp2f(stops)).min(Vec3::splat(1e15));
    ((x * x * a + x * b + c) / (x * x * d + x * e + f)).clamp(Vec3::ZERO, Vec3::ONE)
}
