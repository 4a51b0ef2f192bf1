//! Error estimation from the changes of the image as its sample count doubles.

use super::within::{Estimate, level, sum_and_spread};
use dapple_imaging::Image;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::{MethodKind, Settings};

/// From this count on, the first n Sobol points of a render are a complete point set. A stratified render without a
/// fixed sample count uses sets of this size.
const WHOLE: u32 = 16;

/// A change of the image between two sample counts.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct Change {
    /// Samples per pixel before and after.
    from: u32,
    to: u32,
    /// Mean squared change over pixels and channels.
    square: f64,
    /// Square of the relative standard deviation of `square`.
    spread: f64,
}

/// The changes of a render that is observed at doubling sample counts.
#[derive(Clone, serde::Serialize, serde::Deserialize)]
pub struct Doublings {
    sobol: bool,
    /// The smallest count whose points are a complete set.
    whole: u32,
    last: Option<(u32, Image)>,
    changes: Vec<Change>,
}

impl Doublings {
    /// An estimator for a render with these settings. `None` if parts of it are not complete point sets, because a
    /// stratified render with a fixed sample count proceeds cell by cell.
    pub fn new(settings: &Settings) -> Option<Self> {
        let (sobol, whole) = match (settings.kind(), settings.pattern) {
            (MethodKind::Path, Pattern::Sobol) => (true, WHOLE),
            (MethodKind::Path, Pattern::Stratified) if settings.spp().is_none() => (false, WHOLE),
            (MethodKind::Path, Pattern::Random) => (false, 1),
            (MethodKind::Distribution, _) if settings.samples().is_none() => (false, 1),
            _ => return None,
        };
        Some(Self { sobol, whole, last: None, changes: Vec::new() })
    }

    /// Adds the image at a further sample count.
    pub fn add(&mut self, samples: u32, picture: Image) {
        if let Some((from, old)) = &self.last {
            let squares = old.pixels.iter().zip(&picture.pixels).map(|(a, b)| (*b - *a).as_dvec3());
            let (sum, spread) = sum_and_spread(squares.map(|d| d.length_squared()));
            let square = sum / (3 * picture.pixels.len()) as f64;
            self.changes.push(Change { from: *from, to: samples, square, spread });
        }
        self.last = Some((samples, picture));
    }

    /// The error at the last sample count; `None` with fewer than 2 independent samples or fewer than 64 Sobol points.
    pub fn estimate(&self, confidence: f64) -> Option<Estimate> {
        let change = self.changes.last().filter(|c| c.from >= self.whole)?;
        let level = level(self.last.as_ref()?.1.mean());
        // Valid for independent points; too large for other points.
        let independent = change.square * f64::from(change.from) / f64::from(change.to - change.from);
        let mse = if self.sobol { self.sobol_mse()? } else { independent };
        // The same pixels determine both the true error and its estimate.
        let spread = (2.0 * change.spread).sqrt();
        let high = if self.sobol { 0.5 * (mse + independent) } else { independent };
        Estimate::new(mse, high, spread, level, confidence)
    }

    /// The exponent by which the squared error falls with the samples, as far as it is known; 1 for independent
    /// samples.
    pub fn rate(&self) -> f64 {
        let left = left(&self.whole_changes()).filter(|_| self.sobol);
        left.map_or(1.0, |left| -libm::log2(left))
    }

    fn whole_changes(&self) -> Vec<f64> {
        self.changes.iter().filter(|c| c.from >= self.whole).map(|c| c.square).collect()
    }

    /// The sum of all future changes as a geometric series; over pairs of doublings if there are three changes.
    fn sobol_mse(&self) -> Option<f64> {
        let changes = self.whole_changes();
        let left = left(&changes)?;
        match changes[..] {
            [.., _, b, c] => Some((b + c) * left * left / (1.0 - left * left)),
            [.., b] => Some(b * left / (1.0 - left)),
            [] => None,
        }
    }
}

/// Ratio of a squared change to the previous one. With three changes it is averaged over two doublings, because the
/// convergence of Sobol points is uneven and faster at every other power of two.
fn left(changes: &[f64]) -> Option<f64> {
    match changes {
        [.., a, _, c] => Some(clamped(c / a, 2).sqrt()),
        [a, b] => Some(clamped(b / a, 1)),
        _ => None,
    }
}

/// Clamps the ratio of squared changes after `doublings`: the variance falls at least as 1/n and at most as 1/n².
fn clamped(ratio: f64, doublings: i32) -> f64 {
    let ratio = if ratio.is_nan() { 1.0 } else { ratio };
    ratio.clamp(0.25f64.powi(doublings), 0.5f64.powi(doublings))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_testkit::Rng;
    use glam::Vec3;

    const SIDE: usize = 64;

    /// Images at doubling counts: level 1 plus the mean of n independent numbers of standard deviation ½, accumulated
    /// incrementally. Returns the true error of the last image.
    fn independent(doublings: &mut Doublings, seed: u64, most: u32) -> f64 {
        let mut rng = Rng::new(seed);
        let mut sum = vec![[0.0f64; 3]; SIDE * SIDE];
        let (mut n, mut error) = (0, 0.0);
        for count in (0..).map(|k| 1 << k).take_while(|c| *c <= most) {
            let scale = 0.5 * f64::from(count - n).sqrt();
            sum.iter_mut().flatten().for_each(|s| *s += scale * rng.normal());
            n = count;
            let mean = |s: &[f64; 3]| s.map(|s| s / f64::from(n));
            let pixels = sum.iter().map(|s| Vec3::from(mean(s).map(|v| 1.0 + v as f32))).collect();
            error = sum.iter().flat_map(mean).map(|v| v * v).sum::<f64>() / (3 * SIDE * SIDE) as f64;
            doublings.add(count, Image { width: SIDE, height: SIDE, pixels });
        }
        error.sqrt()
    }

    #[test]
    fn independent_samples_tell_their_error() {
        let settings = Settings { pattern: Pattern::Random, ..Settings::default() };
        let mut held = 0;
        for seed in 0..40 {
            let mut doublings = Doublings::new(&settings).unwrap();
            let truth = independent(&mut doublings, seed, 32);
            let found = doublings.estimate(0.95).unwrap();
            assert!(
                (found.error / truth - 1.0).abs() < 4.0 / (3.0 * (SIDE * SIDE) as f64).sqrt(),
                "{}",
                found.error
            );
            held += u32::from(truth <= found.bound);
        }
        // Binomial (40, 0.95) is below 33 once in 10⁴.
        assert!(held >= 33, "{held}");
        assert!(Doublings::new(&settings).unwrap().estimate(0.95).is_none());
        let cells = Settings { pattern: Pattern::Stratified, ..Settings::default() };
        assert!(Doublings::new(&cells).is_none());
    }

    /// Changes that fall like those of V ∝ n^−p yield V for any p within the bounds.
    #[test]
    fn falling_changes_are_summed_up() {
        for p in [1.0, 1.25, 1.5, 2.0f64] {
            let v = |n: u32| f64::from(n).powf(-p);
            let change =
                |from: u32| Change { from, to: 2 * from, square: v(from) - v(2 * from), spread: 0.0 };
            let doublings = |counts: &[u32]| Doublings {
                sobol: true,
                whole: WHOLE,
                last: Some((2 * counts[counts.len() - 1], Image::filled(1, 1, Vec3::ONE))),
                changes: counts.iter().map(|n| change(*n)).collect(),
            };
            assert!((doublings(&[16, 32, 64]).rate() - p).abs() < 1e-12);
            let found = doublings(&[8, 16, 32]).estimate(0.5).unwrap();
            assert!((found.error - v(64).sqrt()).abs() < 1e-12, "{p}: {}", found.error);
            assert!(found.bound >= found.error * (1.0 - 1e-12));
            let found = doublings(&[16, 32, 64, 128]).estimate(0.5).unwrap();
            assert!((found.error - v(256).sqrt()).abs() < 1e-12, "{p}: {}", found.error);
            assert!(doublings(&[4, 8, 16]).estimate(0.5).is_none());
        }
    }
}
