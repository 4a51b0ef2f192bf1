//! Pixel coverage: the share of a pixel's samples that hit a surface, and the share of each object.
//!
//! Samples are weighted by the pixel filter, as colours are. Alpha is the complement of the visible background: 1 − (Σ
//! weight · open) / n for n samples, where `open` is the share of a sample's rays that hit nothing. The transparent
//! image composited over a background of constant colour therefore equals, up to rounding, the image rendered with that
//! background, for every filter. All filters but Mitchell have weights of 1, and alpha is a fraction of the samples;
//! with negative weights it may be negative or exceed 1. The shares of the objects are normalised, (Σ weight · share) /
//! Σ weight, and clamped to the range 0 to 1.

use crate::aov::Aov;
use crate::settings::Settings;

/// Sums over the samples of each pixel; the vectors of quantities that are not requested are empty.
#[derive(Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Coverage {
    /// Sum of weights of samples that hit nothing, in shares of a sample.
    open: Vec<f64>,
    /// Sum of weights.
    weights: Vec<f64>,
    /// Sum of weighted shares for each object index + 1, in the order of first hits.
    objects: Vec<Vec<(u32, f64)>>,
}

impl Coverage {
    pub fn new(pixels: usize, settings: &Settings) -> Self {
        let has_matte = settings.aovs.contains(&Aov::Cryptomatte);
        let count = |asked| if asked { pixels } else { 0 };
        Self {
            open: vec![0.0; count(settings.transparent)],
            weights: vec![0.0; count(has_matte)],
            objects: vec![Vec::new(); count(has_matte)],
        }
    }

    /// Whether the coverage of every object is recorded.
    pub fn asks_objects(&self) -> bool {
        !self.objects.is_empty()
    }

    /// Whether both have the same sums for the same number of pixels.
    pub fn is_like(&self, other: &Self) -> bool {
        let counts = |of: &Self| [of.open.len(), of.weights.len(), of.objects.len()];
        counts(self) == counts(other)
    }

    /// Bytes per pixel for a pixel that shows one object.
    pub fn bytes_of_a_pixel(&self) -> usize {
        let objects = self.objects.len() * (size_of::<Vec<(u32, f64)>>() + size_of::<(u32, f64)>());
        size_of_val(&*self.weights) + size_of_val(&*self.open) + objects
    }

    /// Adds a sample of which `hits` rays, each with the given share of the sample, hit `objects`.
    pub fn add(
        &mut self,
        pixel: usize,
        weight: f64,
        (hits, share): (u32, f64),
        objects: impl Iterator<Item = u32>,
    ) {
        if let Some(sum) = self.open.get_mut(pixel) {
            *sum += weight * (1.0 - share * f64::from(hits));
        }
        if let Some(sum) = self.weights.get_mut(pixel) {
            *sum += weight;
        }
        if let Some(all) = self.objects.get_mut(pixel) {
            for object in objects {
                match all.iter_mut().find(|(known, _)| *known == object) {
                    Some((_, sum)) => *sum += weight * share,
                    None => all.push((object, weight * share)),
                }
            }
        }
    }

    /// Coverage of a pixel with the given number of samples; 0 without samples.
    pub fn alpha(&self, pixel: usize, samples: u64) -> f32 {
        if samples == 0 { 0.0 } else { (1.0 - self.open[pixel] / samples as f64) as f32 }
    }

    /// Object indices + 1 and their shares.
    pub fn objects(&self, pixel: usize) -> impl Iterator<Item = (u32, f64)> {
        self.objects[pixel].iter().map(move |&(object, sum)| (object, self.share(pixel, sum)))
    }

    fn share(&self, pixel: usize, sum: f64) -> f64 {
        match self.weights[pixel] {
            0.0 => 0.0,
            weights => (sum / weights).clamp(0.0, 1.0),
        }
    }
}
