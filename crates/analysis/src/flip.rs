//! ꟻLIP: the perceived difference of two images that alternate in the same place.
//!
//! ꟻLIP [Andersson et al. 2020] filters both images by the contrast sensitivity of the eye, compares them as colours in
//! a Hunt-adjusted L*a*b* space, and amplifies the difference where edges and points differ. The result is a map of
//! values from 0 (equal) to 1, and its mean. For images of high dynamic range it is the maximum over a series of
//! exposures [Andersson et al. 2021]. The arithmetic is in f32, the mean in f64.
//!
//! ꟻLIP describes the visual appearance and is unsuitable for measuring convergence, because it is not a power of the
//! number of samples.

mod color;
mod feature;
mod filter;
mod hdr;

pub use hdr::{Exposures, exposures};

use crate::metrics::{SizeMismatch, same_size};
use color::{hunt_lab, hyab, linear_to_opponent, opponent_to_linear};
use dapple_imaging::Image;
use glam::Vec3;

/// Pixels per degree of visual angle of the authors' standard observer: a 4K display 0.7 m wide, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = 0.7 * 3840.0 / 0.7 * (std::f32::consts::PI / 180.0);

/// ꟻLIP per pixel, row by row from the top left, 0 to 1; NaN where an image is not finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` values.
    pub values: Vec<f32>,
}

impl Map {
    /// Mean over the pixels that are not NaN; NaN if there are none.
    pub fn mean(&self) -> f64 {
        let numbers = self.values.iter().filter(|v| !v.is_nan());
        let (sum, n) = numbers.fold((0.0, 0.0), |(sum, n), v| (sum + f64::from(*v), n + 1.0));
        sum / n
    }
}

/// ꟻLIP of display images: linear light, clipped to 0…1.
///
/// # Errors
/// The images differ in size.
pub fn ldr(image: &Image, reference: &Image, pixels_per_degree: f32) -> Result<Map, SizeMismatch> {
    same_size(image, reference)?;
    let unit = |p: &Image| finite(p, |v| v.clamp(Vec3::ZERO, Vec3::ONE));
    let size = (image.width, image.height);
    let mut values = difference(size, &unit(image), &unit(reference), pixels_per_degree);
    mark(&mut values, image, reference);
    Ok(Map { width: size.0, height: size.1, values })
}

/// HDR-ꟻLIP: the maximum of ꟻLIP over a series of exposures, which are derived from the reference and tone-mapped with
/// the ACES curve. Negative radiance counts as black.
///
/// # Errors
/// The images differ in size.
pub fn hdr(image: &Image, reference: &Image, pixels_per_degree: f32) -> Result<Map, SizeMismatch> {
    same_size(image, reference)?;
    let size = (image.width, image.height);
    let positive = |p: &Image| finite(p, |v| v.max(Vec3::ZERO));
    let (a, b) = (positive(image), positive(reference));
    let mut values = vec![0.0f32; a.len()];
    for stops in hdr::exposures(reference).stops() {
        let shown = |p: &[Vec3]| p.iter().map(|v| hdr::shown(*v, stops)).collect::<Vec<_>>();
        let one = difference(size, &shown(&a), &shown(&b), pixels_per_degree);
        values.iter_mut().zip(one).for_each(|(v, one)| *v = v.max(one));
    }
    mark(&mut values, image, reference);
    Ok(Map { width: size.0, height: size.1, values })
}

/// Maps pixels by `f`; pixels that are not finite become black.
fn finite(picture: &Image, f: impl Fn(Vec3) -> Vec3) -> Vec<Vec3> {
    picture.pixels.iter().map(|p| if p.is_finite() { f(*p) } else { Vec3::ZERO }).collect()
}

fn mark(values: &mut [f32], image: &Image, reference: &Image) {
    for (v, (a, b)) in values.iter_mut().zip(image.pixels.iter().zip(&reference.pixels)) {
        if !(a.is_finite() && b.is_finite()) {
            *v = f32::NAN;
        }
    }
}

/// ꟻLIP of linear images within 0…1: the colour difference to the power of one minus the feature difference [Andersson
/// et al. 2020, eq. 15].
fn difference(size: (usize, usize), image: &[Vec3], reference: &[Vec3], ppd: f32) -> Vec<f32> {
    let opponent = |p: &[Vec3]| p.iter().map(|v| linear_to_opponent(*v)).collect::<Vec<_>>();
    let (a, b) = (opponent(image), opponent(reference));
    let features = feature::difference(size, &a, &b, ppd);
    let seen = |p: &[Vec3]| -> Vec<Vec3> {
        let blurred = filter::contrast_sensitivity(size, p, ppd);
        blurred.iter().map(|v| hunt_lab(opponent_to_linear(*v).clamp(Vec3::ZERO, Vec3::ONE))).collect()
    };
    let largest = libm::powf(hyab(hunt_lab(Vec3::Y), hunt_lab(Vec3::Z)), COLOUR_POWER);
    let colours = seen(&a).into_iter().zip(seen(&b)).map(|(a, b)| compressed(hyab(a, b), largest));
    colours.zip(features).map(|(colour, feature)| libm::powf(colour, 1.0 - feature)).collect()
}

/// Exponent of the colour distance, q_c.
const COLOUR_POWER: f32 = 0.7;
/// Fraction p_c of the largest distance that is mapped to the value [`KNEE_VALUE`], p_t.
const KNEE: f32 = 0.4;
const KNEE_VALUE: f32 = 0.95;

/// Maps a colour distance to 0…1, giving most of the range to distances that are not extreme [Andersson et al. 2020,
/// §4.3].
fn compressed(distance: f32, largest: f32) -> f32 {
    let powered = libm::powf(distance, COLOUR_POWER);
    let knee = KNEE * largest;
    if powered < knee {
        KNEE_VALUE / knee * powered
    } else {
        KNEE_VALUE + (powered - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
    }
}
