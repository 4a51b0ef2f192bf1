//! What covers a pixel: the share of its samples that meet a surface, and the shares of the objects.
//!
//! Samples count by the weights that the pixel filter gives them, as colours do. Alpha is what is left of the background:
//! 1 − (Σ weight · open) / n of n samples, where `open` is the share of a sample's rays that met nothing. So the
//! transparent picture over a background of one colour is, to rounding, the picture with that background, whatever the
//! filter. All filters but Mitchell have weights of 1, and alpha is a fraction of the samples; with
//! negative weights it may lie outside of 0 and 1. The shares of the objects are parts of a whole,
//! (Σ weight · share) / Σ weight, cut to 0 and 1.

use crate::aov::Aov;
use crate::settings::Settings;

/// Sums over the samples of each pixel; of what is not asked for, nothing.
#[derive(Clone, Default)]
pub(crate) struct Coverage {
    /// Of the weights of samples that met nothing, in shares of a sample.
    open: Vec<f64>,
    /// Of the weights.
    weights: Vec<f64>,
    /// The same for each object + 1 that was met, in the order in which they were.
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

    /// Whether every object that rays meet counts.
    pub fn asks_objects(&self) -> bool {
        !self.objects.is_empty()
    }

    /// What a pixel takes that shows one object.
    pub fn bytes_of_a_pixel(&self) -> usize {
        let objects = self.objects.len() * (size_of::<Vec<(u32, f64)>>() + size_of::<(u32, f64)>());
        size_of_val(&*self.weights) + size_of_val(&*self.open) + objects
    }

    /// Takes in a sample of which `hits` rays, each of this share of it, met `objects`.
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

    /// How much of a pixel of so many samples is covered; 0 without samples.
    pub fn alpha(&self, pixel: usize, samples: u64) -> f32 {
        if samples == 0 { 0.0 } else { (1.0 - self.open[pixel] / samples as f64) as f32 }
    }

    /// Objects + 1 and their shares.
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
