//! Error estimation by rendering some pixels of the image again with other seeds.
//!
//! A pixel that is drawn k times is rendered k times (up to [`MOST`]). With its value I in the image and the mean Ī of
//! the k other renders, k/(k+1)·(I − Ī)² has the expectation of the squared error. For large k it approaches the actual
//! error of this image, so that the estimate is accurate if few pixels account for most of the error.

use super::blocks::{self, Block};
use super::within::{Estimate, level, sum_and_spread};
use dapple_integrator::camera::{Camera, Film, SampleSums};
use dapple_integrator::math::PixelRect;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Settings, sum_pixels_until};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Minimum number of draws: 256 pixels determine the squared error to about an eighth if their errors are similar.
const LEAST: usize = 256;

/// Maximum number of draws, except for images in which four rows are more pixels: these determine the error to a
/// sixtieth, and more would not save samples.
const ENOUGH: usize = 1 << 14;

/// Divisor of the number of pixels that gives the number of draws. Stopping at an error limit requires a bound close to
/// the error: with four rows of 256×192 pixels the bound was a fifth above the estimate, which costs two fifths more
/// samples.
const PART: usize = 16;

/// Maximum number of renders of a pixel. Rendering a pixel often is worthwhile if it accounts for most of the error: a
/// hundred renders determine the error of this image to a tenth, sixteen hardly to a quarter.
const MOST: u32 = 256;

/// Number of pixels that are drawn: a sixteenth of them, up to [`ENOUGH`], but at least four rows of a square image.
/// The accuracy of the estimate does not depend on the number of pixels that were drawn from; but the more there are,
/// the likelier a few of them have far larger errors than the others.
fn draws(rect: PixelRect) -> usize {
    (rect.area() / PART).min(ENOUGH).max(4 * rect.area().isqrt()).max(LEAST)
}

/// The fraction of the image that [`replicate`] renders again; above 1 for the smallest images.
pub fn replicated_share(rect: PixelRect) -> f64 {
    draws(rect) as f64 / rect.area().max(1) as f64
}

/// The error of `film`, a finished render of `spp` samples per pixel with `settings`. Renders some pixels again: a
/// sixteenth of an image of 64×64 to 512×512 pixels, a smaller part of a larger one.
pub fn replicate(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    whole: (&Film, u32),
    confidence: f64,
) -> Option<Estimate> {
    let within = variances(whole.0);
    replicate_until(scene, camera, settings, whole, &within, confidence, &|| false)
}

/// As [`replicate`]; the pixels are drawn by the variances `within` them, row by row. Returns `None` once `stop`, which
/// is polled during rendering, returns true.
pub fn replicate_until(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    (film, spp): (&Film, u32),
    within: &[f32],
    confidence: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Estimate> {
    let first = settings.sample_range().start;
    let samples = first..first.saturating_add(spp);
    Replicates::render((scene, camera, settings), within, samples, stop)?.estimate(film, confidence)
}

/// The variance of the mean of each pixel, summed over channels, row by row.
pub fn variances(film: &Film) -> Vec<f32> {
    film.variance().pixels.iter().map(|variance| variance.element_sum()).collect()
}

/// Sums of the samples of some pixels in renders with other seeds. Parts of a render have those of their own samples,
/// and merged parts the bits of the whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Replicates {
    rect: PixelRect,
    drawn: Vec<Block>,
    /// For each pixel that was drawn, the sums of each of its other renders.
    sums: Vec<Vec<SampleSums>>,
}

impl Replicates {
    /// Renders the samples with indices in `samples` of pixels that are drawn by the variances `within` the pixels of
    /// the image, row by row; `None` once `stop`, which is polled during rendering, returns true.
    pub fn render(
        (scene, camera, settings): (&Scene, &Camera, &Settings),
        within: &[f32],
        samples: Range<u32>,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let rect = settings.rect();
        let within: Vec<f64> = within.iter().map(|variance| f64::from(*variance)).collect();
        let drawn = blocks::drawn(rect, 1, &within, settings.seed, draws(rect));
        let mut sums = vec![Vec::new(); drawn.len()];
        let most = drawn.iter().map(renders).max().unwrap_or(0);
        for k in 0..most {
            let again: Vec<usize> = (0..drawn.len()).filter(|i| renders(&drawn[*i]) > k).collect();
            let pixels: Vec<(u32, u32)> = again.iter().map(|i| pixel(&drawn[*i])).collect();
            let settings = other(settings, k);
            let found = sum_pixels_until(scene, camera, &settings, samples.clone(), &pixels, stop)?;
            again.iter().zip(found).for_each(|(i, found)| sums[*i].push(found));
        }
        Some(Self { rect, drawn, sums })
    }

    /// Adds the samples of another part of the same pixels; returns whether that is possible. If not, there is no
    /// change.
    #[must_use]
    pub fn merge(&mut self, other: &Self) -> bool {
        if self.rect != other.rect || self.drawn != other.drawn || !self.is_whole() || !other.is_whole() {
            return false;
        }
        let mut both = self.sums.clone();
        let pairs = both.iter_mut().flatten().zip(other.sums.iter().flatten());
        let is_merged = pairs.fold(true, |merged, (sums, others)| merged & sums.merge(others).is_ok());
        if is_merged {
            self.sums = both;
        }
        is_merged
    }

    /// Whether there are sums for every pixel that was drawn; in a damaged file there may be others.
    fn is_whole(&self) -> bool {
        let is_inside = |(x, y): (u32, u32)| self.rect.contains(x, y);
        self.sums.len() == self.drawn.len()
            && self.drawn.iter().all(|block| block.times > 0 && is_inside(pixel(block)))
            && self.drawn.iter().zip(&self.sums).all(|(block, sums)| sums.len() == renders(block) as usize)
    }

    /// The pixels of the image that the error of these renders stands for.
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// The error of `film`, whose samples have the same indices; none if it cannot be estimated.
    pub fn estimate(&self, film: &Film, confidence: f64) -> Option<Estimate> {
        let (sum, squares) = self.is_whole().then(|| self.errors(film))?;
        let within: Vec<f64> = film.variance().pixels.iter().map(|v| v.as_dvec3().element_sum()).collect();
        judged((sum, squares), &within, level(film.mean().mean()), confidence)
    }

    /// The squared error, summed over the pixels, and the sum of its squares.
    fn errors(&self, film: &Film) -> (f64, f64) {
        let other = |sums: &Vec<SampleSums>| sums.iter().map(|sums| sums.finish().1.mean).sum();
        let errors = self.drawn.iter().zip(&self.sums).map(|(b, sums)| (b, square(film, b, other(sums))));
        summed(errors)
    }
}

/// The error of `film`, of whose pixels each of `parts` stands for some; none if it cannot be estimated, or if they are
/// not all pixels.
pub fn replicated(parts: &[Replicates], film: &Film, confidence: f64) -> Option<Estimate> {
    let area: usize = parts.iter().map(|part| part.rect.area()).sum();
    if area != film.rect().area() || !parts.iter().all(Replicates::is_whole) {
        return None;
    }
    let errors = parts.iter().map(|part| part.errors(film));
    let (sum, squares) = errors.fold((0.0, 0.0), |all, part| (all.0 + part.0, all.1 + part.1));
    let within: Vec<f64> = film.variance().pixels.iter().map(|v| v.as_dvec3().element_sum()).collect();
    judged((sum, squares), &within, level(film.mean().mean()), confidence)
}

/// Number of other renders of a pixel.
fn renders(block: &Block) -> u32 {
    block.times.min(MOST)
}

fn pixel(block: &Block) -> (u32, u32) {
    (block.rect.x0, block.rect.y0)
}

/// The same settings with another seed for each k.
fn other(settings: &Settings, k: u32) -> Settings {
    let seed = settings.seed ^ 0x5eed_5eed_5eed_5eed ^ (u64::from(k) << 32);
    Settings { seed, aovs: Vec::new(), ..settings.clone() }
}

/// The weighted squared error of a pixel, summed over channels; `sum` is the sum of its other renders.
fn square(film: &Film, block: &Block, sum: DVec3) -> f64 {
    let (k, (x, y)) = (f64::from(renders(block)), pixel(block));
    block.weight * k / (k + 1.0) * (film.mean_at(x, y) - sum / k).length_squared()
}

/// Sum of the weighted squared errors of the pixels that were drawn, and the sum of their squares. Each draw is an
/// independent value.
fn summed<'a>(errors: impl Iterator<Item = (&'a Block, f64)>) -> (f64, f64) {
    errors.fold((0.0, 0.0), |(sum, squares), (b, e)| (sum + e, squares + e * e / f64::from(b.times)))
}

/// The estimate from the [`summed`] errors of the pixels that were drawn and the variances `within` all pixels, both
/// summed over channels.
fn judged((sum, squares): (f64, f64), within: &[f64], level: f64, confidence: f64) -> Option<Estimate> {
    let spread = if sum > 0.0 { squares / (sum * sum) } else { 0.0 };
    // The true error varies as well, in particular if few pixels dominate it.
    let (known, within_spread) = sum_and_spread(within.iter().copied());
    let own = if known.is_finite() { within_spread } else { spread };
    let mse = sum / (3 * within.len()) as f64;
    Estimate::new(mse, mse, (spread + own).sqrt(), level, confidence)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_integrator::sampling::Key;
    use dapple_testkit::Rng;

    fn pixels(r: PixelRect) -> impl Iterator<Item = (u32, u32)> {
        (r.y0..r.y1).flat_map(move |y| (r.x0..r.x1).map(move |x| (x, y)))
    }

    #[test]
    fn the_larger_the_picture_the_smaller_the_part() {
        let share = |side: u32| {
            let rect = PixelRect { x0: 0, y0: 0, x1: side, y1: side };
            draws(rect) as f64 / rect.area() as f64
        };
        assert_eq!(
            [32, 64, 128, 512, 1024, 8192].map(share),
            [0.25, 0.0625, 0.0625, 0.0625, 0.015625, 4.0 / 8192.0]
        );
    }

    /// Evaluates 500 images of independent pixel errors, whose standard deviations follow `deviation` and are known
    /// from the variances within pixels up to a factor that varies by block. Returns the share of images whose true
    /// error is within the bound.
    fn held(rect: PixelRect, deviation: impl Fn(u32, u32) -> f64) -> f64 {
        let factor = |x: u32, y: u32| 1.0 + (Key::pixel(3, x / 8, y / 8).bits() >> 61) as f64;
        let variance = |(x, y): (u32, u32)| deviation(x, y).powi(2);
        let within: Vec<f64> = pixels(rect).map(|(x, y)| 3.0 * factor(x, y) * variance((x, y))).collect();
        let mut rng = Rng::new(5);
        let held = (0..500u64).filter(|seed| {
            let mut normal = || rng.normal();
            let errors: Vec<f64> = pixels(rect).map(|p| variance(p).sqrt() * normal()).collect();
            let truth = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
            let drawn = blocks::drawn(rect, 1, &within, *seed, draws(rect));
            let mut square = |b: &Block| {
                let (k, (x, y)) = (f64::from(b.times.min(MOST)), pixel(b));
                let other = variance((x, y)).sqrt() * normal() / k.sqrt();
                let mine = errors[(y * rect.width() + x) as usize];
                b.weight * 3.0 * k / (k + 1.0) * (mine - other).powi(2)
            };
            let all = summed(drawn.iter().map(|block| (block, square(block))));
            judged(all, &within, 1.0, 0.95).unwrap().bound >= truth.sqrt()
        });
        held.count() as f64 / 500.0
    }

    /// 95 % of 500 trials minus four standard errors is 91.1 %.
    #[test]
    fn bounds_hold_as_often_as_they_promise() {
        let rect = |x1, y1| PixelRect { x0: 0, y0: 0, x1, y1 };
        let even = held(rect(128, 96), |_, _| 1.0);
        let edges = held(rect(128, 96), |x, y| if (x + y) % 40 < 3 { 1.0 } else { 0.02 });
        let corner = held(rect(96, 64), |x, y| if x < 6 && y < 6 { 1.0 } else { 0.05 });
        let small = held(rect(24, 24), |x, _| 1.0 + f64::from(x));
        for (name, share) in [("even", even), ("edges", edges), ("corner", corner), ("small", small)] {
            println!("{name}: {share}");
            assert!(share >= 0.911, "{name}: {share}");
        }
    }
}
