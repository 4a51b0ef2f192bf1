//! Validation of settings, and the identity of renders that can be resumed or merged.

use super::{DistributionSettings, Limits, Method, PathSettings, Settings};
use crate::effects::{Combine, Effect};
use dapple_math::PixelRect;
use dapple_sampling::Pattern;

/// Error for invalid or contradictory settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// The image has no pixels, or more than can be addressed.
    #[error("an image of {0}x{1} pixels cannot be rendered; each side must have 1 to 65536 pixels")]
    Size(u32, u32),
    /// The crop has no pixels, or some outside of the image.
    #[error("the crop {x0},{y0} to {x1},{y1} is empty or extends outside of the image; give 0 ≤ x0 < x1 ≤ width and 0 ≤ y0 < y1 ≤ height", x0 = .0.x0, y0 = .0.y0, x1 = .0.x1, y1 = .0.y1)]
    Crop(PixelRect),
    /// The range of samples or rounds is empty.
    #[error("the range of samples {0}..{1} is empty; give an end greater than the start")]
    NoSamples(u32, u32),
    /// Adaptive sampling may end a pixel after any number of points, which this pattern does not support.
    #[error(
        "adaptive sampling does not support {0} points, which form a fixed set per pixel; use sobol or random points"
    )]
    AdaptivePattern(Pattern),
    /// Adaptive sampling computes the sample allocation from the whole image.
    #[error(
        "adaptive sampling depends on the whole image and cannot be combined with a crop; leave out one of the two"
    )]
    AdaptiveCrop,
    /// Adaptive sampling computes the sample allocation from the first samples.
    #[error(
        "adaptive sampling needs the first samples; start the range at 0 or give the sample allocation of another render"
    )]
    AdaptiveStart,
    /// In paired mode, every integral has one point per pixel sample.
    #[error(
        "{effect}: {count} points, but paired integrals take one for each of the pixel's {pixel} points; give 1, {pixel} or 0"
    )]
    Paired {
        /// The integral.
        effect: Effect,
        /// Its number of points.
        count: u32,
        /// Number of points of the pixel.
        pixel: u32,
    },
    /// A radiance is negative or not finite.
    #[error("{0} must be a finite radiance of at least 0")]
    Radiance(&'static str),
    /// The state belongs to a render with other settings.
    #[error(
        "the state belongs to a render with other settings; resume it with the settings it was started with"
    )]
    OtherRender,
}

/// Sobol points depend on the size of their set only up to this size ([`dapple_sampling::padded_2d`]).
const SOBOL_BLOCK: u32 = 16;

/// Maximum number of pixels per side.
const LARGEST: u32 = 1 << 16;

impl Settings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Returns the first contradiction found.
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

    /// The settings that two renders must share so that one can continue the other, or both can be merged.
    pub(crate) fn identity(&self) -> String {
        let mut of = self.clone();
        (of.limits, of.crop) = (Limits::default(), None);
        let block = self.block();
        let mut shares = String::new();
        match &mut of.method {
            Method::Path(path) => {
                (path.samples, path.of) = (0..0, None);
                let allocation = path.allocation.take();
                shares =
                    allocation.map_or_else(String::new, |allocation| format!(" {:x}", allocation.digest()));
            }
            Method::Distribution(distribution) => (distribution.rounds, distribution.samples) = (0..0, None),
        }
        // Random points do not depend on the size of their set, and Sobol points only on that of the first block.
        let fixed = match self.pattern {
            Pattern::Random => 0,
            Pattern::Sobol => block.min(SOBOL_BLOCK),
            Pattern::Stratified | Pattern::Grid => block,
        };
        format!("{fixed}{shares} {of:?}")
    }
}
