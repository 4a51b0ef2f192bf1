//! The stated error of an image: estimate, bound, and whether the bound is reliable.

use super::unseen::{Hidden, Unseen};
use super::within::Estimate;

/// Maximum share of the bound, or of the requested limit, that unseen light may contribute to a reliable bound: at most
/// 15 % more.
pub const SHARE: f64 = 0.5;

/// An error estimate including the light that no sample has found.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Verdict {
    /// The expected error of the observed light, as relative RMSE.
    pub error: f64,
    /// An upper bound of the true error, unseen light included, with the requested confidence.
    pub bound: f64,
    /// The relative RMSE that unseen light may add.
    pub unseen: f64,
    /// Whether the bound is reliable.
    pub reliable: bool,
    /// The reason, in words.
    pub why: String,
}

impl Verdict {
    /// The verdict on an estimate. If the error should be below `limit`, unseen light has to be small compared with the
    /// limit; otherwise compared with the bound.
    pub fn new(found: Estimate, unseen: Option<Unseen>, limit: Option<f64>) -> Self {
        let more = unseen.map_or(f64::INFINITY, |unseen| unseen.error);
        let bound = found.bound.hypot(more);
        let reliable = more.is_finite() && more <= SHARE * bound.max(limit.unwrap_or_default());
        Self { error: found.error, bound, unseen: more, reliable, why: why(unseen, reliable) }
    }

    /// The factor on the sample count at which the bound is expected to be `limit` and reliable; at most `most`. `seen`
    /// is the bound of the observed light at the next check, whose square falls with the samples by the exponent
    /// `rate`; the contribution of unseen light is inversely proportional to the samples.
    pub fn growth(&self, seen: f64, limit: f64, rate: f64, most: f64) -> f64 {
        let enough = |more: f64| {
            let unseen = self.unseen / more;
            let square = seen * seen * libm::pow(more, -rate) + unseen * unseen;
            square <= limit * limit && unseen <= SHARE * limit
        };
        let (mut low, mut high) = (1.0, most);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if enough(middle) { high = middle } else { low = middle }
        }
        high
    }
}

fn why(unseen: Option<Unseen>, reliable: bool) -> String {
    let Some(unseen) = unseen else { return "too few samples, or no light in the image".into() };
    let more = 100.0 * unseen.error;
    if reliable {
        return format!("light that no sample has found adds at most {more:.2} % to the error");
    }
    let what = match unseen.what {
        Hidden::Emitters => {
            "emitters that light sampling cannot find, seen through smooth surfaces or by the camera"
        }
        Hidden::Lit => "small surfaces close to a light, or onto which light is focused",
        Hidden::Highlights => "highlights of rough surfaces whose centre few samples hit",
        Hidden::Outliers => "a few samples that carry most of the variance",
    };
    let much = if more.is_finite() { format!("up to {more:.2} %") } else { "any amount".into() };
    format!(
        "{what} may add {much} to the error; single samples reach {:.0} times the mean radiance",
        unseen.times
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOUND: Estimate = Estimate { error: 0.02, bound: 0.03 };

    fn unseen(error: f64) -> Option<Unseen> {
        Some(Unseen { error, what: Hidden::Emitters, times: 300.0 })
    }

    #[test]
    fn what_was_not_seen_has_to_be_small() {
        let small = Verdict::new(FOUND, unseen(0.015), None);
        assert!(small.reliable && (small.bound - 0.03f64.hypot(0.015)).abs() < 1e-12);
        let large = Verdict::new(FOUND, unseen(0.02), None);
        assert!(
            !large.reliable && large.why.contains("emitters") && large.why.contains("300 times"),
            "{}",
            large.why
        );
        // Small compared with the limit.
        assert!(Verdict::new(FOUND, unseen(0.02), Some(0.04)).reliable);
        assert!(!Verdict::new(FOUND, unseen(0.02), Some(0.03)).reliable);
        assert!(!Verdict::new(FOUND, None, None).reliable);
        assert!(Verdict::new(FOUND, unseen(f64::INFINITY), None).why.contains("any amount"));
    }

    #[test]
    fn samples_grow_until_both_are_small() {
        let verdict = |error| Verdict::new(FOUND, unseen(error), None);
        // Only the observed error: (0.03 / 0.015)².
        assert!((verdict(0.0).growth(0.03, 0.015, 1.0, 16.0) - 4.0).abs() < 1e-6);
        // Only the unseen part: half the limit.
        assert!((verdict(0.06).growth(0.0, 0.03, 1.0, 16.0) - 4.0).abs() < 1e-6);
        assert!((verdict(9.0).growth(0.03, 0.03, 1.0, 4.0) - 4.0).abs() < 1e-6);
        let both = verdict(0.01).growth(0.03, 0.03, 1.0, 4.0);
        assert!((0.03f64.powi(2) / both + (0.01 / both).powi(2) - 0.0009).abs() < 1e-9, "{both}");
    }
}
