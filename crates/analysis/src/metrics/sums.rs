//! Accumulation of the metrics over channels and pixels.

use super::measures::{Measures, Scale};

/// The contribution of one channel of one pixel.
pub(super) struct Term {
    reference: f64,
    error: f64,
    square: f64,
    relative: f64,
    absolute: f64,
    symmetric: f64,
}

impl Term {
    /// The terms of an image value and two reference values, which are equal if the reference is exact.
    pub fn new(image: f32, halves: [f32; 2], scale: &Scale) -> Self {
        let (image, [a, b]) = (f64::from(image), halves.map(f64::from));
        let reference = 0.5 * (a + b);
        let error = image - reference;
        let square = (image - a) * (image - b);
        Self {
            reference,
            error,
            square,
            relative: square / (reference * reference + scale.epsilon),
            absolute: error.abs() / (reference.abs() + scale.epsilon),
            symmetric: error.abs() / (image.abs() + reference.abs() + scale.epsilon),
        }
    }
}

/// Running sums. The relative terms are stored individually, because trimming requires their order.
#[derive(Default)]
pub(super) struct Sums {
    reference: f64,
    error: f64,
    square: f64,
    absolute: f64,
    symmetric: f64,
    relative: Vec<f64>,
    max: f64,
    max_at: Option<usize>,
}

impl Sums {
    pub fn add(&mut self, term: &Term, pixel: usize) {
        self.reference += term.reference;
        self.error += term.error;
        self.square += term.square;
        self.absolute += term.absolute;
        self.symmetric += term.symmetric;
        self.relative.push(term.relative);
        if self.max_at.is_none() || term.error.abs() > self.max {
            self.max = term.error.abs();
            self.max_at = Some(pixel);
        }
    }

    pub fn finish(mut self, scale: &Scale, place: impl Fn(usize) -> [usize; 2]) -> Measures {
        let n = self.relative.len() as f64;
        let mse = self.square / n;
        Measures {
            mse,
            rmse: mse.sqrt(),
            relative_rmse: mse.sqrt() / (self.reference / n),
            relmse: self.relative.iter().sum::<f64>() / n,
            relmse_trimmed: trimmed_mean(&mut self.relative, scale.trim),
            bias: self.error / n,
            mape: self.absolute / n,
            smape: self.symmetric / n,
            psnr: 10.0 * libm::log10(scale.peak * scale.peak / mse),
            max_error: if self.max_at.is_some() { self.max } else { f64::NAN },
            max_error_pixel: self.max_at.map(place),
        }
    }
}

/// The mean without the largest `share` of the terms, rounded down to whole terms. Reorders the terms.
fn trimmed_mean(terms: &mut [f64], share: f64) -> f64 {
    let dropped = (terms.len() as f64 * share.clamp(0.0, 1.0)) as usize;
    let kept = terms.len() - dropped;
    if dropped > 0 && kept > 0 {
        terms.select_nth_unstable_by(kept - 1, f64::total_cmp);
    }
    terms[..kept].iter().sum::<f64>() / kept as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trimming_drops_the_largest() {
        let mut terms: Vec<f64> = (0..1000).map(|i| f64::from(i * 7919 % 1000)).collect();
        assert_eq!(trimmed_mean(&mut terms, 0.01), (0..990).sum::<i32>() as f64 / 990.0);
        assert_eq!(trimmed_mean(&mut terms, 0.0), 499.5);
        assert_eq!(trimmed_mean(&mut [4.0], 0.001), 4.0);
        assert!(trimmed_mean(&mut [], 0.001).is_nan());
    }
}
