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
use dapple_math::FixedSum;

/// Sums over the samples of each pixel; the vectors of quantities that are not requested are empty.
#[derive(Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Coverage {
    /// Sum of weights of samples that hit nothing, in shares of a sample.
    open: Vec<FixedSum>,
    /// Sum of weights.
    weights: Vec<FixedSum>,
    /// Sum of weighted shares for each object index + 1, in ascending order.
    objects: Vec<Vec<(u32, FixedSum)>>,
}

impl Coverage {
    pub fn new(pixels: usize, settings: &Settings) -> Self {
        let has_matte = settings.aovs.contains(&Aov::Cryptomatte);
        let count = |asked| if asked { pixels } else { 0 };
        Self {
            open: vec![FixedSum::default(); count(settings.transparent)],
            weights: vec![FixedSum::default(); count(has_matte)],
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
        let objects = self.objects.len() * (size_of::<Vec<(u32, FixedSum)>>() + size_of::<(u32, FixedSum)>());
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
            sum.add(weight * (1.0 - share * f64::from(hits)));
        }
        if let Some(sum) = self.weights.get_mut(pixel) {
            sum.add(weight);
        }
        if let Some(all) = self.objects.get_mut(pixel) {
            objects.for_each(|object| of(all, object).add(weight * share));
        }
    }

    /// Adds the sums of other samples of the same pixels.
    pub fn merge(&mut self, other: &Self) {
        self.open.iter_mut().zip(&other.open).for_each(|(sum, other)| sum.merge(other));
        self.weights.iter_mut().zip(&other.weights).for_each(|(sum, other)| sum.merge(other));
        for (all, others) in self.objects.iter_mut().zip(&other.objects) {
            others.iter().for_each(|(object, sum)| of(all, *object).merge(sum));
        }
    }

    /// Empty sums of the same kinds for another number of pixels.
    pub fn like(&self, pixels: usize) -> Self {
        let count = |is_empty: bool| if is_empty { 0 } else { pixels };
        Self {
            open: vec![FixedSum::default(); count(self.open.is_empty())],
            weights: vec![FixedSum::default(); count(self.weights.is_empty())],
            objects: vec![Vec::new(); count(self.objects.is_empty())],
        }
    }

    /// Whether the sums are those of `pixels` pixels.
    pub fn is_of(&self, pixels: usize) -> bool {
        [self.open.len(), self.weights.len(), self.objects.len()].iter().all(|len| [0, pixels].contains(len))
            && self.weights.len() == self.objects.len()
    }

    /// Adds the sums of pixel `from` of `other` to pixel `to`.
    pub fn merge_pixel(&mut self, to: usize, other: &Self, from: usize) {
        let sums = [(&mut self.open, &other.open), (&mut self.weights, &other.weights)];
        for (sums, others) in sums {
            if let (Some(sum), Some(other)) = (sums.get_mut(to), others.get(from)) {
                sum.merge(other);
            }
        }
        if let (Some(all), Some(others)) = (self.objects.get_mut(to), other.objects.get(from)) {
            others.iter().for_each(|(object, sum)| of(all, *object).merge(sum));
        }
    }

    /// Coverage of a pixel with the given number of samples; 0 without samples.
    pub fn alpha(&self, pixel: usize, samples: u64) -> f32 {
        if samples == 0 { 0.0 } else { (1.0 - self.open[pixel].value() / samples as f64) as f32 }
    }

    /// Object indices + 1 and their shares.
    pub fn objects(&self, pixel: usize) -> impl Iterator<Item = (u32, f64)> {
        self.objects[pixel].iter().map(move |(object, sum)| (*object, self.share(pixel, sum.value())))
    }

    fn share(&self, pixel: usize, sum: f64) -> f64 {
        match self.weights[pixel].value() {
            0.0 => 0.0,
            weights => (sum / weights).clamp(0.0, 1.0),
        }
    }
}

/// The sum of an object, which is 0 if it has none yet.
fn of(all: &mut Vec<(u32, FixedSum)>, object: u32) -> &mut FixedSum {
    let at = all.binary_search_by_key(&object, |(known, _)| *known).unwrap_or_else(|at| {
        all.insert(at, (object, FixedSum::default()));
        at
    });
    &mut all[at].1
}
