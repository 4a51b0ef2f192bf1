//! The largest deviation of a function in f32 from its reference in f64, and the input where it occurs.

use std::fmt::{self, Debug};

/// The largest deviation of one function so far.
#[derive(Clone, Debug)]
pub struct Deviation {
    /// Name of the function.
    pub name: String,
    /// Largest deviation.
    pub worst: f64,
    /// Input of the largest deviation.
    pub input: String,
    /// Number of compared inputs.
    pub count: u64,
    /// Largest tolerated deviation.
    pub bound: f64,
}

impl Deviation {
    /// Creates a deviation without comparisons.
    pub fn new(name: impl Into<String>, bound: f64) -> Self {
        Self { name: name.into(), worst: 0.0, input: String::new(), count: 0, bound }
    }

    /// Adds the deviation |value − exact| relative to |exact|.
    pub fn relative(&mut self, value: f32, exact: f64, input: impl Debug) {
        let off =
            if f64::from(value) == exact { 0.0 } else { (f64::from(value) - exact).abs() / exact.abs() };
        self.off(off, input);
    }

    /// Adds the deviation |value − exact| relative to `scale`.
    pub fn absolute(&mut self, value: f32, exact: f64, scale: f64, input: impl Debug) {
        self.off((f64::from(value) - exact).abs() / scale, input);
    }

    /// Adds a deviation computed by the caller. NaN counts as infinite.
    pub fn off(&mut self, off: f64, input: impl Debug) {
        let off = if off.is_nan() { f64::INFINITY } else { off };
        self.count += 1;
        if off > self.worst || self.input.is_empty() {
            (self.worst, self.input) = (off, format!("{input:?}"));
        }
    }

    /// Returns whether there was a comparison and no deviation is above the bound.
    pub fn passed(&self) -> bool {
        self.count > 0 && self.worst <= self.bound
    }
}

impl fmt::Display for Deviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, worst, input, count, bound } = self;
        write!(f, "{name:44} {worst:9.2e}  (at most {bound:.0e}) of {count:7} at {input}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_input_is_kept() {
        let mut d = Deviation::new("f", 0.2);
        assert!(!d.passed(), "nothing was compared");
        d.relative(1.0, 1.0, "same");
        d.relative(1.1, 1.0, "off");
        d.relative(0.0, 0.0, "zero");
        assert!(d.passed() && d.input.contains("off") && d.count == 3);
        d.relative(f32::NAN, 1.0, "bad");
        assert!(!d.passed() && d.to_string().contains("bad"));
    }
}
