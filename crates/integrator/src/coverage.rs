//! What covers a pixel: the share of its samples that meet a surface, and the shares of the objects.
//!
//! Shares are taken by the weights that the pixel filter gives the samples, as colours are: (Σ weight · share) / Σ weight,
//! cut to 0 and 1. All filters but Mitchell have weights of 1, so that the shares are fractions of the samples.

use crate::aov::Aov;
use crate::settings::Settings;

/// Sums over the samples of each pixel; of what is not asked for, nothing.
#[derive(Clone, Default)]
pub(crate) struct Coverage {
    /// Of the weights.
    weights: Vec<f64>,
    /// Of the weights of samples that met something, in shares of a sample.
    hits: Vec<f64>,
    /// The same for each object + 1 that was met, in the order in which they were.
    objects: Vec<Vec<(u32, f64)>>,
}

impl Coverage {
    pub fn new(pixels: usize, settings: &Settings) -> Self {
        let has_matte = settings.aovs.contains(&Aov::Cryptomatte);
        let count = |asked| if asked { pixels } else { 0 };
        Self {
            weights: vec![0.0; count(settings.transparent || has_matte)],
            hits: vec![0.0; count(settings.transparent)],
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
        size_of_val(&*self.weights) + size_of_val(&*self.hits) + objects
    }

    /// Takes in a sample of which `hits` rays, each of this share of it, met `objects`.
    pub fn add(
        &mut self,
        pixel: usize,
        weight: f64,
        (hits, share): (u32, f64),
        objects: impl Iterator<Item = u32>,
    ) {
        let Some(sum) = self.weights.get_mut(pixel) else { return };
        *sum += weight;
        if let Some(sum) = self.hits.get_mut(pixel) {
            *sum += weight * share * f64::from(hits);
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

    /// The share of a pixel that is covered; 0 without samples.
    pub fn alpha(&self, pixel: usize) -> f32 {
        self.share(pixel, self.hits[pixel]) as f32
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
