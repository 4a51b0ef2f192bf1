//! Which settings make sense, and which renders belong together.

use super::{DistributionSettings, Limits, Method, PathSettings, Settings};
use crate::effects::{Combine, Effect};
use dapple_math::PixelRect;
use dapple_sampling::Pattern;

/// Settings that contradict each other or mean nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// An image without pixels, or with more than can be addressed.
    #[error(
        "an image of {0}x{1} pixels cannot be rendered; give it at least one pixel and at most 65536 on each side"
    )]
    Size(u32, u32),
    /// The crop has no pixels, or some outside of the image.
    #[error("the crop {x0},{y0} to {x1},{y1} is not a part of the image; give 0 ≤ x0 < x1 ≤ width and 0 ≤ y0 < y1 ≤ height", x0 = .0.x0, y0 = .0.y0, x1 = .0.x1, y1 = .0.y1)]
    Crop(PixelRect),
    /// A range of samples or rounds without any.
    #[error("the range of samples {0}..{1} is empty; let it end after its start")]
    NoSamples(u32, u32),
    /// Adaptive sampling continues the points of each pixel at will.
    #[error(
        "adaptive sampling continues a pixel's points, and {0} points belong together; use sobol or random points"
    )]
    AdaptivePattern(Pattern),
    /// Adaptive sampling looks at the whole image to decide.
    #[error(
        "adaptive sampling decides by the whole image, so that a crop would differ from it; leave out one of the two"
    )]
    AdaptiveCrop,
    /// The samples that decide are the first.
    #[error(
        "adaptive sampling decides by the first samples; start the range at 0 or give the shares of another render"
    )]
    AdaptiveStart,
    /// Paired, every integral has one point per pixel sample.
    #[error(
        "{effect}: {count} points, but paired integrals take one for each of the pixel's {pixel}; give 1, {pixel} or 0"
    )]
    Paired {
        /// The integral.
        effect: Effect,
        /// Its points.
        count: u32,
        /// Those of the pixel.
        pixel: u32,
    },
    /// A radiance that is negative or not a number.
    #[error("{0} has to be a finite radiance of at least 0")]
    Radiance(&'static str),
    /// The state of a render with other settings.
    #[error("the state belongs to a render with other settings; resume it with those it was begun with")]
    OtherRender,
}

/// Pixels per side at most.
const LARGEST: u32 = 1 << 16;

impl Settings {
    /// Whether the settings make sense.
    ///
    /// # Errors
    /// The first contradiction found.
    pub fn check(&self) -> Result<(), SettingsError> {
        let (w, h) = self.size;
        if w == 0 || h == 0 || w > LARGEST || h > LARGEST {
            return Err(SettingsError::Size(w, h));
        }
        if let Some(crop) = self.crop
            && (crop.area() == 0 || crop.x1 > w || crop.y1 > h)
        {
            return Err(SettingsError::Crop(crop));
        }
        let range = self.sample_range();
        if range.is_empty() {
            return Err(SettingsError::NoSamples(range.start, range.end));
        }
        if self.clamp.is_some_and(|most| !(most.is_finite() && most > 0.0)) {
            return Err(SettingsError::Radiance("the clamp"));
        }
        if !(self.ambient.is_finite() && self.ambient.min_element() >= 0.0) {
            return Err(SettingsError::Radiance("the ambient radiance"));
        }
        match &self.method {
            Method::Path(path) => self.check_path(path),
            Method::Distribution(distribution) => self.check_distribution(distribution),
        }
    }

    fn check_path(&self, path: &PathSettings) -> Result<(), SettingsError> {
        match self.pattern {
            _ if !path.adaptive || path.allocation.is_some() => Ok(()),
            Pattern::Stratified | Pattern::Grid => Err(SettingsError::AdaptivePattern(self.pattern)),
            _ if self.crop.is_some() => Err(SettingsError::AdaptiveCrop),
            _ if path.samples.start > 0 => Err(SettingsError::AdaptiveStart),
            _ => Ok(()),
        }
    }

    fn check_distribution(&self, distribution: &DistributionSettings) -> Result<(), SettingsError> {
        let pixel = self.round();
        let is_wrong = |effect: &Effect| {
            let count = self.plans.of(*effect).count();
            *effect != Effect::Pixel && count > 1 && count != pixel
        };
        let mut all = Effect::ALL.iter().map(|(effect, _)| *effect);
        match all.find(is_wrong).filter(|_| distribution.combine == Combine::Paired) {
            Some(effect) => {
                Err(SettingsError::Paired { effect, count: self.plans.of(effect).count(), pixel })
            }
            None => Ok(()),
        }
    }

    /// What two renders must share so that one can go on where the other stopped.
    pub(crate) fn identity(&self) -> String {
        let mut of = self.clone();
        of.limits = Limits::default();
        let block = self.block();
        match &mut of.method {
            Method::Path(path) => (path.samples.end, path.of) = (0, None),
            Method::Distribution(distribution) => distribution.rounds.end = 0,
        }
        // Random points alone do not know how many there are.
        let fixed = if self.pattern == Pattern::Random { 0 } else { block };
        format!("{fixed} {of:?}")
    }
}
