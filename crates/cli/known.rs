//! What is known of a picture's error when it is done.

/// By the picture's own account.
#[derive(Clone, Debug, Default)]
pub struct Known {
    /// Expected relative RMSE; none where it cannot be known or nobody asked.
    pub error: Option<f64>,
    /// What the true one is not above; none where that cannot be relied on.
    pub bound: Option<f64>,
    /// Whether a bound can be stated.
    pub reliable: bool,
    /// Why, or why not.
    pub why: String,
    /// Wall time of finding out, beside rendering.
    pub seconds: f64,
}

impl Known {
    /// Nobody asked.
    pub fn unasked() -> Self {
        Self { why: "nobody asked".into(), ..Self::default() }
    }

    /// For people.
    pub fn summary(&self) -> String {
        match (self.error, self.bound) {
            (Some(e), Some(b)) => format!("; error about {:.2} %, below {:.2} %", 100.0 * e, 100.0 * b),
            (Some(e), None) => {
                format!(
                    "; error about {:.2} % by what was seen, no bound is known\nno bound: {}",
                    100.0 * e,
                    self.why
                )
            }
            _ => String::new(),
        }
    }
}
