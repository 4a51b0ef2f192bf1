//! Estimated error of a finished image.

/// Confidence level of error bounds, unless another is requested.
pub const CONFIDENCE: f64 = 0.95;

/// Error estimate of an image, from its own samples.
#[derive(Clone, Debug, Default)]
pub struct Known {
    /// Expected relative RMSE; none if it cannot be estimated or was not requested.
    pub error: Option<f64>,
    /// Upper bound of the true error; none if no bound is reliable.
    pub bound: Option<f64>,
    /// Whether a reliable bound exists.
    pub reliable: bool,
    /// Reason why there is a bound, or why there is none.
    pub why: String,
    /// Wall-clock time spent on the estimate, apart from rendering.
    pub seconds: f64,
}

impl Known {
    /// The result when no error estimate was requested.
    pub fn unasked() -> Self {
        Self { why: "not requested".into(), ..Self::default() }
    }

    /// Formats the estimate for the summary line.
    pub fn summary(&self) -> String {
        match (self.error, self.bound) {
            (Some(e), Some(b)) => format!("; error about {:.2} %, below {:.2} %", 100.0 * e, 100.0 * b),
            (Some(e), None) => {
                format!(
                    "; error about {:.2} % from the samples so far, no reliable bound\nno bound: {}",
                    100.0 * e,
                    self.why
                )
            }
            _ => String::new(),
        }
    }
}
