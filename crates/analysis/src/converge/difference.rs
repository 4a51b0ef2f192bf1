//! Test whether two references converge to the same image.
//!
//! Methods that are compared with references of their own are comparable only as far as these references agree. With
//! halves A₁, A₂ and B₁, B₂, the mean of (A₁ − B₁)(A₂ − B₂) is an unbiased estimate of the squared difference between
//! the expectations of both references, free of the noise of all four renders.

use super::reference::Reference;
use crate::metrics::{self, SizeMismatch};
use dapple_imaging::Image;

/// Number of standard errors above 0 from which a difference is significant.
const SURE: f64 = 4.0;

/// The difference of two references.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apart {
    /// Mean squared difference over pixels and channels, without the noise of halves; it may be negative.
    pub mse: f64,
    /// Standard error of `mse` over pixels.
    pub error: f64,
    /// Sum of the mean squared errors of both means, as far as they come in halves.
    pub noise: f64,
    /// Whether the noise of both references is known: each comes in halves.
    pub noise_is_known: bool,
}

impl Apart {
    /// Whether the references differ by more than noise.
    pub fn is_sure(&self) -> bool {
        self.mse > SURE * self.error
    }
}

/// Compares two references of equal size.
///
/// # Errors
/// The references differ in size.
pub fn apart(a: &Reference, b: &Reference) -> Result<Apart, SizeMismatch> {
    let ([a1, a2], [b1, b2]) = (halves(a), halves(b));
    metrics::same_size(a1, b1)?;
    let product = |i: usize| {
        let d = |a: &Image, b: &Image| (a.pixels[i] - b.pixels[i]).as_dvec3();
        (d(a1, b1) * d(a2, b2)).element_sum() / 3.0
    };
    let terms: Vec<f64> = (0..a1.pixels.len()).map(product).filter(|t| t.is_finite()).collect();
    let n = terms.len() as f64;
    let mse = terms.iter().sum::<f64>() / n;
    let squares = terms.iter().map(|t| (t - mse) * (t - mse)).sum::<f64>();
    let is_known = |r: &Reference| matches!(r, Reference::Halves(_));
    Ok(Apart {
        mse,
        error: (squares / (n - 1.0).max(1.0) / n).sqrt(),
        noise: a.mse() + b.mse(),
        noise_is_known: is_known(a) && is_known(b),
    })
}

fn halves(reference: &Reference) -> [&Image; 2] {
    match reference {
        Reference::Exact(picture) => [picture, picture],
        Reference::Halves([a, b]) => [a, b],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_testkit::Rng;
    use glam::Vec3;

    fn drawn(level: f64, noise: f64, rng: &mut Rng) -> Image {
        let one = |rng: &mut Rng| Vec3::from([0; 3].map(|_: i32| (level + noise * rng.normal()) as f32));
        Image { width: 40, height: 30, pixels: (0..1200).map(|_| one(rng)).collect() }
    }

    /// A difference of a third of the noise of one pixel is found over 1200 pixels. Noise alone is not significant at 4
    /// standard errors in 400 trials.
    #[test]
    fn differences_are_told_from_noise() {
        let mut rng = Rng::new(5);
        let mut of = |level: f64| Reference::Halves([0; 2].map(|_| drawn(level, 0.3, &mut rng)));
        let same = (0..400).filter(|_| apart(&of(1.0), &of(1.0)).unwrap().is_sure()).count();
        assert!(same <= 1, "{same}");
        let found = apart(&of(1.0), &of(1.1)).unwrap();
        assert!(found.is_sure() && found.noise_is_known, "{found:?}");
        assert!((found.mse - 0.01).abs() < 4.0 * found.error, "{found:?}");
        // The mean of two halves has half the variance of one half.
        assert!((found.noise - 0.09).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn one_picture_keeps_its_noise() {
        let mut rng = Rng::new(6);
        let one = Reference::Exact(drawn(1.0, 0.3, &mut rng));
        let other = Reference::Halves([0; 2].map(|_| drawn(1.0, 0.3, &mut rng)));
        let found = apart(&one, &other).unwrap();
        assert!(found.is_sure() && !found.noise_is_known && (found.mse - 0.09).abs() < 0.02, "{found:?}");
        let small = Reference::Exact(Image::filled(2, 2, Vec3::ONE));
        assert!(apart(&one, &small).is_err());
    }
}
