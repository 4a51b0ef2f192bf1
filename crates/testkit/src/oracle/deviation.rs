//! How far is a function in f32 from its f64 reference over its whole domain, and where is it worst?

use std::fmt::{self, Debug};

/// The largest deviation seen of one function.
#[derive(Clone, Debug)]
pub struct Deviation {
    /// Of which function.
    pub name: String,
    /// Largest deviation.
    pub worst: f64,
    /// The input it was found at.
    pub input: String,
    /// How many inputs were compared.
    pub count: u64,
    /// Most that is tolerated.
    pub bound: f64,
}

impl Deviation {
    /// Of nothing yet.
    pub fn new(name: impl Into<String>, bound: f64) -> Self {
        Self { name: name.into(), worst: 0.0, input: String::new(), count: 0, bound }
    }

    /// |value − exact| relative to |exact|.
    pub fn relative(&mut self, value: f32, exact: f64, input: impl Debug) {
        let off =
            if f64::from(value) == exact { 0.0 } else { (f64::from(value) - exact).abs() / exact.abs() };
        self.off(off, input);
    }

    /// |value − exact| relative to `scale`.
    pub fn absolute(&mut self, value: f32, exact: f64, scale: f64, input: impl Debug) {
        self.off((f64::from(value) - exact).abs() / scale, input);
    }

    /// A deviation worked out elsewhere; not-a-number is infinite.
    pub fn off(&mut self, off: f64, input: impl Debug) {
        let off = if off.is_nan() { f64::INFINITY } else { off };
        self.count += 1;
        if off > self.worst || self.input.is_empty() {
            (self.worst, self.input) = (off, format!("{input:?}"));
        }
    }

    /// Whether something was compared, and nothing deviates by more than is tolerated.
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
